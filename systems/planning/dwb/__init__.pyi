from .choose import Candidates as Candidates, candidates as candidates
from .dwb import (
    CriticParameters as CriticParameters,
    CriticScales as CriticScales,
    DwbPlanner as DwbPlanner,
)
from .dwb_memory import DwbMemory as DwbMemory
from .scl import SclPlanner as SclPlanner
from .weighing import velocity_samples as velocity_samples
