"""Verification jobs: their queue, their worker, their results, and the Redis behind them."""
