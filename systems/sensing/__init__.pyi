from .camera import AddCamera as AddCamera
from .delay import Delay as Delay
from .lidar import Lidar as Lidar
from .localization import Localization as Localization
from .localization_config import (
    LOCALIZATIONS as LOCALIZATIONS,
    ErrorModel as ErrorModel,
    LocalizationConfig as LocalizationConfig,
    register_localization as register_localization,
)
from .people_detector import PeopleDetector as PeopleDetector
from .scans import scan_points as scan_points
from .sensor_config import (
    SENSORS as SENSORS,
    CameraConfig as CameraConfig,
    LidarConfig as LidarConfig,
    PeopleDetectorConfig as PeopleDetectorConfig,
    SensingTask as SensingTask,
    SensorConfig as SensorConfig,
    VisiblePeopleConfig as VisiblePeopleConfig,
    register_sensor as register_sensor,
)
from .visible_people import VisiblePeople as VisiblePeople
