"""Job process: entry point of a job's process: loads the program's modules, then runs the worker.

Runs as `python -P -m limbgram.cases.job_process CASE`.
"""

import sys
from importlib import import_module

from limbgram.core.run import garbage_collection_paused

if __name__ == "__main__":
    with garbage_collection_paused():
        worker = import_module("limbgram.cases.job_worker")
    sys.exit(worker.main())
