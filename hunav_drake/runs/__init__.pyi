from .recording_files import ReadRecording as ReadRecording
from .result_files import LoadResults as LoadResults, WriteResult as WriteResult
from .run_suite import RunSuite as RunSuite
from .run_table import ReadRuns as ReadRuns
from .statistics import compare as compare, summarize as summarize
from .suite import Suite as Suite
from .suite_file import ListSuites as ListSuites, LoadSuite as LoadSuite
from .suite_result import SuiteResult as SuiteResult
