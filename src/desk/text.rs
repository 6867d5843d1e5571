//! Numbers as people read them.

use overlook_engine::plural::noun;
use overlook_engine::preprocess::diagnostics::PixelAccount;

/// A count with three significant figures: `970`, `12.4 k`, `3.15 M`.
pub(crate) fn count(value: u64) -> String {
    scaled(value as f64, ["", " k", " M", " G", " T"])
}

/// A count with three significant figures and its noun: `1 sample`, `12.4 k samples`.
pub(crate) fn count_of(value: u64, singular: &str) -> String {
    format!("{} {}", count(value), noun(value, singular))
}

/// Bytes in powers of 1000: `970 B`, `12.4 kB`, `3.15 MB`.
pub(crate) fn bytes(value: u64) -> String {
    scaled(value as f64, [" B", " kB", " MB", " GB", " TB"])
}

fn scaled(mut value: f64, units: [&str; 5]) -> String {
    let mut unit = 0;
    while value >= 999.5 && unit + 1 < units.len() {
        value /= 1000.0;
        unit += 1;
    }
    if unit == 0 {
        format!("{value:.0}{}", units[0])
    } else {
        format!("{}{}", significant(value), units[unit])
    }
}

/// Three significant figures of a number below 1000; two between 0.1 and 1.
pub(crate) fn significant(value: f64) -> String {
    match value.abs() {
        v if v >= 99.95 => format!("{value:.0}"),
        v if v >= 9.995 => format!("{value:.1}"),
        v if v >= 0.0995 || v == 0.0 => format!("{value:.2}"),
        v if v >= 0.9995e-4 => {
            // What is rounded up to the next power of ten needs a decimal less.
            let decimals = 2 - (v / 0.9995).log10().floor() as i32;
            format!("{value:.*}", decimals.unsigned_abs() as usize)
        }
        _ => format!("{value:.2e}"),
    }
}

/// The share of `part` in `whole` as a percentage; `–` if `whole` is 0.
pub(crate) fn percent(part: u64, whole: u64) -> String {
    if whole == 0 { "–".to_owned() } else { format!("{:.1} %", 100.0 * part as f64 / whole as f64) }
}

/// How long something still takes, no finer than anybody believes.
pub(crate) fn time_left(secs: f32) -> String {
    match secs {
        s if s < 1.5 => "a second left".to_owned(),
        s if s < 90.0 => format!("{s:.0} s left"),
        s => format!("{:.0} min left", s / 60.0),
    }
}

/// The same text with a capital first letter.
pub(crate) fn sentence(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

/// A name of the code as words: `depth_tolerance` → `Depth tolerance`.
pub(crate) fn words(name: &str) -> String {
    sentence(&name.replace(['_', '-'], " "))
}

/// A duration: `21.8 s`, `7 min 48 s`.
pub(crate) fn duration(seconds: f64) -> String {
    if seconds < 59.5 {
        return format!("{} s", significant(seconds));
    }
    let whole = seconds.round() as u64;
    format!("{} min {} s", whole / 60, whole % 60)
}

/// How long reading all frames and pruning them took, seconds; `None` where the frames were read before.
pub(crate) fn took(read: Option<f64>, pruned: f64) -> String {
    match read {
        Some(read) => format!("Read in {}, pruned in {}", duration(read), duration(pruned)),
        None => format!("Pruned in {}", duration(pruned)),
    }
}

/// What became of all pixels, in words: shares that add up.
pub(crate) fn account_parts(account: &PixelAccount) -> [(&'static str, u64); 7] {
    [
        ("kept", account.kept),
        ("repeated over time", account.repeated),
        ("redundant between cameras", account.redundant),
        ("without depth", account.without_depth),
        ("blended at an edge", account.mixed),
        ("contradicted", account.contradicted),
        ("cut by hand", account.cut),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reading_and_pruning_are_told_apart() {
        assert_eq!(took(Some(447.2), 21.84), "Read in 7 min 27 s, pruned in 21.8 s");
        assert_eq!(took(None, 59.6), "Pruned in 1 min 0 s");
        assert_eq!(took(None, 0.5), "Pruned in 0.50 s");
    }

    #[test]
    fn numbers_keep_three_significant_figures() {
        assert_eq!(count(970), "970");
        assert_eq!(count(12_400), "12.4 k");
        assert_eq!(count(999_600), "1.00 M");
        assert_eq!(bytes(3_151_000), "3.15 MB");
        assert_eq!([bytes(999), bytes(1000)], ["999 B", "1.00 kB"]);
        assert_eq!(percent(1, 8), "12.5 %");
        assert_eq!(percent(0, 0), "–");
        for (value, text) in [
            (0.0, "0.00"),
            (0.5, "0.50"),
            (0.0996, "0.10"),
            (0.0123, "0.0123"),
            (-0.004_56, "-0.00456"),
            (0.009_999, "0.0100"),
            (0.000_123_4, "0.000123"),
            (0.000_012_34, "1.23e-5"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(significant(value), text);
        }
        assert_eq!(words("depth_tolerance"), "Depth tolerance");
    }
}
