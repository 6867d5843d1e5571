//! Writing OpenEXR frames.
