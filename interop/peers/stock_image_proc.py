"""Stock's image_proc, for which Debian's ros-image-proc lacks the description of its plugins."""

from __future__ import annotations

from pathlib import Path

STOCK = Path("/usr/lib/image_proc/image_proc")
LOADER = Path("/usr/lib/nodelet/nodelet")
CLASSES = {"debayer": "Debayer", "rectify": "Rectify", "resize": "Resize", "crop_decimate": "CropDecimate"}


def overlay(home: Path) -> dict[str, str]:
    """Write the description of stock's nodelets to a folder; return the variables with which it is found."""
    share, lib = home / "share" / "image_proc", home / "lib"
    share.mkdir(parents=True)
    lib.mkdir()
    [library] = Path("/usr/lib").glob("*/libimage_proc.so.0d")
    (lib / "libimage_proc.so").symlink_to(library)
    (share / "package.xml").write_text(
        "<package><name>image_proc</name><version>1.0.0</version><description>-</description><license>BSD</license>"
        '<maintainer email="nobody@example.com">nobody</maintainer><run_depend>nodelet</run_depend>'
        '<export><nodelet plugin="${prefix}/plugins.xml"/></export></package>'
    )
    classes = "".join(
        f'<class name="image_proc/{name}" type="image_proc::{cls}Nodelet" base_class_type="nodelet::Nodelet"/>'
        for name, cls in CLASSES.items()
    )
    (share / "plugins.xml").write_text(f'<library path="libimage_proc">{classes}</library>')
    return {"ROS_PACKAGE_PATH": f"{home / 'share'}:/usr/share", "CMAKE_PREFIX_PATH": f"{home}:/usr"}
