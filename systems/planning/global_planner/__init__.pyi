from .navfn import GlobalPath as GlobalPath, plan_path as plan_path
from .smoothing import smooth_path as smooth_path
