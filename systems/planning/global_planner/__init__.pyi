from .navfn import (
    GlobalPath as GlobalPath,
    plan_path as plan_path,
    smooth_path as smooth_path,
)
