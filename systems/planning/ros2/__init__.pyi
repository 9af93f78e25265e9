from .bridge import BridgePlanner as BridgePlanner
from .dds import DdsNode as DdsNode, Reader as Reader
from .message_types import message as message, type_store as type_store
