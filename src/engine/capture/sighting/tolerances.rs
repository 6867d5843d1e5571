//! What counts as the same depth when a point of one camera is looked for in another, by the one who asks: less than this share of the
//! depth that was found there, or of what stands for it in an orthographic camera ([`crate::capture::Intrinsics::depth_scale`]). Each was tried at the values of the others; a value of its own has its reason.

/// A surface as one pixel of a real sensor shows it, with all its noise: choice of views, what a picture in an edit shows, and samples that
/// determine a color lens, which alone is in doubt there. At 2 % the choice of views loses 0.5 dB, at 5 % nothing changes.
pub const NOISY_PIXEL: f64 = 0.03;

/// A pixel whose color or normal stands for the point: the surface has to be the same. Rows of turned pictures, and normals that are
/// carried into the pixels of color, where one sensor measured both depths.
pub const TAKEN_OVER: f64 = 0.02;

/// Which cameras overlap: before the alignment, poses may be far off, and depths with them. At 10 % more samples are kept, at 5 and 3 %
/// recordings lose 0.06 and 0.1 dB.
pub const OVERLAPS: f64 = 0.15;

/// Points of a true picture that a camera saw: one of nine pixels has to be as close, so that noise needs no wider tolerance.
pub const SEEN_POINTS: f64 = 0.015;

/// The sample that a pixel of a rendered picture was painted from: the picture is as exact as the samples, so that what is farther off is
/// another surface.
pub const PAINTED_SAMPLE: f64 = 0.01;

/// A mark in the rendered picture: depths of surfaces that are splatted over each other are blended there.
pub const MARKED_SURFACE: f64 = 0.03;
