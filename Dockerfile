FROM python:3.11-slim
# PyPI's torch brings CUDA; pass PyTorch's CPU index as PIP_EXTRA_INDEX_URL for an image of a tenth of the size.
ARG PIP_EXTRA_INDEX_URL
WORKDIR /asperity
COPY pyproject.toml README.md ./
COPY solver solver
COPY model model
COPY worker worker
COPY app app
RUN pip install --no-cache-dir .
RUN useradd --create-home asperity && mkdir /state && chown asperity /state
USER asperity
ENV ASPERITY_HOST=0.0.0.0 ASPERITY_STATE_DIR=/state
EXPOSE 8000
CMD ["asperity", "serve"]
