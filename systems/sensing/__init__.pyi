from .camera import AddCamera as AddCamera
from .lidar import Lidar as Lidar
from .scans import scan_points as scan_points
from .sensor_config import (
    SENSORS as SENSORS,
    CameraConfig as CameraConfig,
    LidarConfig as LidarConfig,
    SensingTask as SensingTask,
    SensorConfig as SensorConfig,
    VisiblePeopleConfig as VisiblePeopleConfig,
    register_sensor as register_sensor,
)
from .visible_people import VisiblePeople as VisiblePeople
