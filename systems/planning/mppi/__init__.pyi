from .mppi import MppiPlanner as MppiPlanner
from .mppi_memory import MppiMemory as MppiMemory
