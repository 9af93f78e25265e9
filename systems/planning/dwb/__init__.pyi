from .dwb import (
    Candidates as Candidates,
    CriticParameters as CriticParameters,
    CriticScales as CriticScales,
    DwbPlanner as DwbPlanner,
    candidates as candidates,
)
from .dwb_memory import DwbMemory as DwbMemory
from .scl import SclPlanner as SclPlanner
from .weighing import velocity_samples as velocity_samples
