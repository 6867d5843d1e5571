//! Reading OpenEXR frames.
