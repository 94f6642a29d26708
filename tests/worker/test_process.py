import subprocess
import sys


def test_a_worker_never_loads_torch() -> None:
    """A fork after multi-threaded torch work deadlocks; what is not there cannot do so."""
    code = "import sys, worker.process; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
