from .orca import OrcaPlanner as OrcaPlanner
from .sfm import SfmPlanner as SfmPlanner
from .sfw import SfwPlanner as SfwPlanner
