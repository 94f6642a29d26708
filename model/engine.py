"""The network compiled for this machine's processor by OpenVINO: in bf16 where the processor has it, for any shape."""

import sys
from collections import deque

import torch
from torch import Tensor

from model.features import CHANNELS, CONDITIONS
from model.network import MULTIPLE, ContactNet
from solver.threads import threads

sys.modules["openvino_telemetry"] = None  # type: ignore[assignment]  # or OpenVINO would report its use to its maker
import openvino  # noqa: E402


class Engine:
    """A compiled network; threads may share it.

    Args:
        network: fused, ready to evaluate.
    """

    def __init__(self, network: ContactNet) -> None:
        example = torch.zeros(1, CHANNELS, MULTIPLE, MULTIPLE), torch.zeros(1, CONDITIONS)
        model = openvino.convert_model(network, example_input=example, input=[[-1, CHANNELS, -1, -1], [-1, CONDITIONS]])
        config = {"PERFORMANCE_HINT": "LATENCY", "INFERENCE_NUM_THREADS": str(threads())}
        self._compiled = openvino.Core().compile_model(model, "CPU", config)
        self._idle = deque([self._compiled.create_infer_request()])

    def __call__(self, fields: Tensor, conditions: Tensor) -> Tensor:
        """As :meth:`model.network.ContactNet.forward`."""
        try:
            request = self._idle.pop()
        except IndexError:
            request = self._compiled.create_infer_request()
        said = request.infer([fields.numpy(), conditions.numpy()], share_inputs=True, share_outputs=True)
        copied = torch.from_numpy(said[0].copy())
        self._idle.append(request)
        return copied
