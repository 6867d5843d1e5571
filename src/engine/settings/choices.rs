//! The choices that settings have, by the names that files and the command line use.

use super::choice::choice;

choice! {
    /// Whether what the rig got wrong is corrected.
    pub enum Correction {
        /// Everything is taken as the capture gives it.
        Off = "off",
        /// Errors are measured, and corrected where samples that took no part in measuring agree that it pays. What a program rendered is
        /// exact by its own word, or by what its depth shows: of it nothing but a pose that is wrong beyond doubt is corrected.
        Auto = "auto",
        /// As auto, of what a program rendered too.
        On = "on",
    }
}

choice! {
    /// Where normals come from.
    pub enum NormalSource {
        /// Given normals where the capture has them, estimated ones elsewhere.
        Auto = "auto",
        /// Estimated from depth even where normals are given.
        Estimated = "estimated",
    }
}

choice! {
    /// How normals are estimated from depth.
    pub enum NormalEstimator {
        /// Cross product of the two flattest one-sided differences of neighboring points: sharp, sensitive to noise.
        Cross = "cross",
        /// Least-squares plane in inverse depth over a 5×5 window cut at depth steps: smooth, robust to noise.
        Plane = "plane",
    }
}

choice! {
    /// Which spans of frames a sample may live in.
    pub enum SpanLevels {
        /// Every frame for itself: nothing is shared over time.
        Off = "off",
        /// The paper's split: a pixel is background over all frames, or foreground in each one.
        Paper = "paper",
        /// Spans of all lengths, half as long at each level: a pixel lives in the longest over which it is static.
        Tree = "tree",
    }
}

choice! {
    /// Which of two samples of the same surface point stays.
    pub enum PruningMethod {
        /// Every sample stays.
        Off = "off",
        /// The first camera that saw the point, whatever its sampling rate: what a layered depth image does.
        FirstCamera = "first_camera",
        /// The camera that sampled the point at the highest rate: the paper's rule.
        HighestRate = "highest_rate",
    }
}

choice! {
    /// How the sampling rate of a pixel is measured.
    pub enum RateModel {
        /// The longest side (`stretch`) where cameras differ in focal length or resolution, the paper's ratio where they are alike.
        Auto = "auto",
        /// The paper's r: planar depth over cosine of incidence. Knows nothing of focal length and resolution.
        Paper = "paper",
        /// Surface area of a pixel, z² cos α / (fx fy cos θ).
        Footprint = "footprint",
        /// Longest side of a pixel on the surface, z √(cos α) / (min(fx, fy) cos θ): the paper's r with focal length and resolution.
        Stretch = "stretch",
    }
}

choice! {
    /// What happens to samples with a color blended across a silhouette, or a depth in the air between its sides.
    pub enum MixedPixels {
        /// They are samples like any other.
        Keep = "keep",
        /// They lose against clean samples of the same surface, whatever the rates. Their own camera contradicts flying pixels. Blended
        /// pixels of the sky are dropped, and the sky is continued over them.
        Yield = "yield",
        /// They are removed before anything else.
        Drop = "drop",
    }
}

choice! {
    /// What becomes of samples that other cameras contradict, and how noise between cameras is treated.
    pub enum AgreementRule {
        /// Other cameras are not consulted, and noise between them is not measured.
        Off = "off",
        /// A sample is dropped where more cameras contradict it than confirm it.
        Majority = "majority",
    }
}

choice! {
    /// How much of color and depth a store keeps.
    pub enum Precision {
        /// Every bit.
        Lossless = "lossless",
        /// Color to half a step of a display with 16 bits, depth to `depth_precision`.
        Bits16 = "bits16",
        /// Color to half a step of a display with 12 bits, depth to `depth_precision`.
        Bits12 = "bits12",
        /// Color to half a step of a display with 10 bits, depth to `depth_precision`.
        Bits10 = "bits10",
        /// Color to half a step of a display with 8 bits, depth to `depth_precision`.
        Bits8 = "bits8",
    }
}

choice! {
    /// How a store codes its samples.
    pub enum Coding {
        /// Predicted from neighbors and the frame before; what is left is entropy-coded.
        Modeled = "modeled",
        /// Every number as it is.
        Plain = "plain",
    }
}

choice! {
    /// How samples become pixels.
    pub enum Kernel {
        /// One pixel per sample.
        Point = "point",
        /// The paper's coarse blending: a sample is spread over the 2×2 pixels around its position.
        Block = "block",
        /// Oriented footprints, blended among samples of one surface by sampling rate.
        Surfel = "surfel",
        /// Surface first, color second: each pixel's surface point is looked up in the cameras that saw it best.
        Gather = "gather",
    }
}

impl Kernel {
    /// Whether pixels show surfaces between samples. Kernels that do not are simple on purpose, and stay so.
    #[must_use]
    pub fn interpolates(self) -> bool {
        matches!(self, Self::Surfel | Self::Gather)
    }
}

choice! {
    /// How pixels without any sample are filled.
    pub enum Fill {
        /// Holes are shown as holes.
        None = "none",
        /// Holes are filled smoothly from the farther of the surfaces around them; they still count as holes.
        PushPull = "pushpull",
    }
}

choice! {
    /// How kernels that interpolate smooth what is finer than a pixel. Each step takes longer than the one before.
    pub enum Antialias {
        /// Each pixel shows what is at its center.
        Off = "off" or "false",
        /// `gather` finds silhouettes at half a pixel; a picture coarser than the recording is rendered finer and averaged.
        Silhouettes = "silhouettes" or "true",
        /// Edges are also rendered twice as fine and averaged, but for close-ups: those of what fills holes are smoothed too, in twice to
        /// three times the time.
        Supersampled = "supersampled",
    }
}

impl Antialias {
    /// That of pictures in motion, where the next one follows at once.
    #[must_use]
    pub fn in_motion(self) -> Self {
        if self == Self::Supersampled { Self::Silhouettes } else { self }
    }
}

choice! {
    /// How pictures coarser than the recording are rendered.
    pub enum Coarse {
        /// Finer, and averaged: takes a third to two thirds of the time of a picture as fine as the recording.
        Average = "average",
        /// From samples that were averaged beforehand, as coarse as the picture: at a quarter of the width and height about three
        /// times as fast as `average`, and 9 to 11 dB less exact.
        Pyramid = "pyramid",
    }
}

choice! {
    /// How parts of a picture that are finer than any camera recorded are rendered.
    pub enum Magnified {
        /// As the rest. Gaps and steps as wide as a recorded pixel can be seen.
        Direct = "direct",
        /// With a few pixels to a recorded one, and upsampled: smoother, without gaps between samples.
        Upsampled = "upsampled",
    }
}

choice! {
    /// What renders.
    pub enum Backend {
        /// The faster of CPU and GPU, as measured on the first picture.
        Auto = "auto",
        /// The CPU.
        Cpu = "cpu",
        /// The GPU, or a software Vulkan driver.
        Gpu = "gpu",
    }
}

choice! {
    /// Which colors stand for scalar values.
    pub enum Colormap {
        /// From dark violet over green to yellow: perceptually uniform, safe for the color-blind.
        Viridis = "viridis",
        /// From dark blue over gray to yellow: the same to eyes that see fewer colors.
        Cividis = "cividis",
        /// From black over purple to a light yellow: perceptually uniform, with the widest range of brightness.
        Magma = "magma",
        /// From black over red to a bright yellow: perceptually uniform.
        Inferno = "inferno",
        /// From purple over white to orange: for values on both sides of zero, safe for the color-blind.
        Diverging = "diverging",
        /// A color for each whole number: for labels and indices.
        Categories = "categories",
    }
}

choice! {
    /// How a range of scalar values runs over a colormap.
    pub enum ValueScale {
        /// Evenly.
        Linear = "linear",
        /// Evenly in logarithms; values that are not above 0 are shown as missing.
        Log = "log",
        /// Evenly, as far below zero as above it.
        Symmetric = "symmetric",
    }
}
