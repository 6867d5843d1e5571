#!/usr/bin/env python3
"""Makes two small pictures and what other programs say about them; tests/metrics.rs holds Overlook's metrics against that.

    pip install numpy==2.4.6 scipy scikit-image==0.26.0 flip-evaluator==1.7 pillow && python3 make.py

truth.png    edges, a gradient, fine texture and thin lines
picture.png  the same, shifted in one part, blurred in another, with noise, a color cast and a hole elsewhere
values.json  psnr_db, ssim: scikit-image. flip: the authors' evaluator, LDR. ms_ssim: the authors' msssim.m, in numpy below.
"""
import json
from pathlib import Path

import flip_evaluator
import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter
from scipy.signal import convolve2d
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

HERE = Path(__file__).parent
WIDTH, HEIGHT = 208, 180


def truth():
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    picture = np.stack([x / WIDTH, y / HEIGHT, 0.5 + 0.4 * np.sin(0.05 * (x + y))], axis=-1)
    disc = (x - 70) ** 2 + (y - 60) ** 2 < 40**2
    picture[disc] = np.stack([0.9 + 0 * x, 0.4 + 0.3 * np.sin(0.9 * x), 0.1 + 0 * x], axis=-1)[disc]
    checks = (x > 110) & (y > 90)
    picture[checks] = (((x // 5 + y // 5) % 2)[checks, None]) * np.array([0.2, 0.7, 0.9])
    picture[:, 140:141] = [1.0, 1.0, 0.2]
    picture[20:21, :] = [0.1, 0.0, 0.2]
    return np.clip(picture, 0, 1)


def painted(picture):
    rng = np.random.default_rng(7)
    changed = picture.copy()
    changed[:90, 104:] = picture[:90, 103:-1]
    changed[90:, :104] = gaussian_filter(picture, (1.5, 1.5, 0))[90:, :104]
    changed[90:, 104:] *= [1.0, 0.93, 1.0]
    changed += rng.normal(0, 0.015, changed.shape)
    changed[100:112, 20:40] = 0.0
    return np.clip(changed, 0, 1)


def luma(bytes_):
    return bytes_.astype(float) @ [0.299, 0.587, 0.114]


def ms_ssim(a, b):
    offsets = np.arange(-5, 6)
    window = np.exp(-(offsets[:, None] ** 2 + offsets[None, :] ** 2) / (2 * 1.5**2))
    window /= window.sum()
    mean = lambda image: convolve2d(image, window, mode="valid")
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    product = 1.0
    weights = [0.0448, 0.2856, 0.3001, 0.2363, 0.1333]
    for scale, weight in enumerate(weights):
        ma, mb = mean(a), mean(b)
        contrast = (2 * (mean(a * b) - ma * mb) + c2) / (mean(a * a) - ma**2 + mean(b * b) - mb**2 + c2)
        whole = contrast * (2 * ma * mb + c1) / (ma**2 + mb**2 + c1)
        product *= (whole if scale == 4 else contrast).mean() ** weight
        a, b = (halved(image) for image in (a, b))
    return product


def halved(image):
    image = np.pad(image, [(0, n % 2) for n in image.shape], mode="symmetric")
    return 0.25 * (image[0::2, 0::2] + image[1::2, 0::2] + image[0::2, 1::2] + image[1::2, 1::2])


def main():
    pictures = {"truth": truth()}
    pictures["picture"] = painted(pictures["truth"])
    encoded = {name: np.round(255 * picture).astype(np.uint8) for name, picture in pictures.items()}
    for name, picture in encoded.items():
        Image.fromarray(picture).save(HERE / f"{name}.png", optimize=True)
    a, b = luma(encoded["truth"]), luma(encoded["picture"])
    ssim = structural_similarity(
        a, b, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=255
    )
    error_map, mean_flip, _ = flip_evaluator.evaluate(
        encoded["truth"].astype(np.float32) / 255,
        encoded["picture"].astype(np.float32) / 255,
        "LDR",
        applyMagma=False,
    )
    values = {
        "psnr_db": peak_signal_noise_ratio(encoded["truth"], encoded["picture"], data_range=255),
        "ssim": ssim,
        "ms_ssim": ms_ssim(a, b),
        "flip": float(mean_flip),
        "flip_pixels": {
            f"{x},{y}": float(np.squeeze(error_map)[y, x])
            for x, y in [(0, 0), (30, 105), (70, 60), (140, 50), (150, 150), (207, 179)]
        },
    }
    (HERE / "values.json").write_text(json.dumps(values, indent=1) + "\n")
    print(json.dumps(values, indent=1))


main()
