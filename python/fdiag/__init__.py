"""Why does my simulator differ from reality?

`gap` says which unmodelled effect separates a simulator from logs of the real system; `spec` trains an on-line
diagnosis. Simulators are model files (`Model`), objects (`Steps`) and functions (`rollout`) of Python, programs
(`Process`), FMUs (`Fmu`) and MuJoCo scenes (`MuJoCo`).
"""

from . import errors
from ._fdiag import __version__
from ._gap import gap
from ._stated import Initial, Output, Port, Uncertain
from .errors import AnalysisError, Diverged, Error, InputError, SimulatorError
from .mujoco import MuJoCo
from .online import Pipeline, Run, Step, Trained, spec
from .programs import Fmu, Process
from .result import Cause, Closed, Finding, HeldOut, Parameter, Result, Signals, Trace, Work
from .simulators import Channel, Model, Rollout, Simulator, Steps, rollout

__all__ = [
    "AnalysisError",
    "Cause",
    "Channel",
    "Closed",
    "Diverged",
    "Error",
    "Finding",
    "Fmu",
    "HeldOut",
    "Initial",
    "InputError",
    "Model",
    "MuJoCo",
    "Output",
    "Parameter",
    "Pipeline",
    "Port",
    "Process",
    "Result",
    "Rollout",
    "Run",
    "Signals",
    "Simulator",
    "SimulatorError",
    "Step",
    "Steps",
    "Trace",
    "Trained",
    "Uncertain",
    "Work",
    "__version__",
    "errors",
    "gap",
    "rollout",
    "spec",
]
