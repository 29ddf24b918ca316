"""Why does my simulator differ from reality?

`gap` says which unmodelled effect separates a simulator from logs of the real system; `spec` trains an on-line
diagnosis. Simulators are model files (`Model`), objects (`Steps`) and functions (`rollout`) of Python, programs
(`Process`), FMUs (`Fmu`) and MuJoCo scenes (`MuJoCo`).
"""

from . import errors
from ._fdiag import __version__
from ._gap import gap
from ._stated import Initial, Native, Output, Port, Uncertain
from .calibration import Calibration, calibrate
from .checks import Check, Checked, Cost, check
from .effects import Effect
from .errors import AnalysisError, Diverged, Error, InputError, SimulatorError
from .experiments import Experiment, next_experiment
from .gymnasium import Gymnasium
from ._mjcf import WrittenScene
from .mujoco import MuJoCo
from .online import Pipeline, Run, Step, Trained, spec
from .programs import Fmu, Process, forbid_programs
from .result import Cause, Closed, Finding, HeldOut, Parameter, Result, Signals, Trace, Work
from .rollouts import Rollout, rollout
from .simulators import Channel, Model, Simulator, Steps

__all__ = [
    "AnalysisError",
    "Calibration",
    "Cause",
    "Channel",
    "Check",
    "Checked",
    "Closed",
    "Cost",
    "Diverged",
    "Effect",
    "Error",
    "Experiment",
    "Finding",
    "Fmu",
    "Gymnasium",
    "HeldOut",
    "Initial",
    "InputError",
    "Model",
    "MuJoCo",
    "Native",
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
    "WrittenScene",
    "__version__",
    "calibrate",
    "check",
    "errors",
    "forbid_programs",
    "gap",
    "next_experiment",
    "rollout",
    "spec",
]
