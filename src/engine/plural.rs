//! Nouns and verbs that agree with a count.

use std::fmt::Display;

/// A count with its noun: `1 frame`, `3 frames`, `0 entries`.
pub fn counted<N: Display + Copy + PartialEq + From<u8>>(count: N, singular: &str) -> String {
    format!("{count} {}", noun(count, singular))
}

/// A noun alone, in the number that a count wants: `frame` for 1, else `frames`.
pub fn noun<N: Copy + PartialEq + From<u8>>(count: N, singular: &str) -> String {
    if count == N::from(1) {
        return singular.to_owned();
    }
    match singular.strip_suffix('y') {
        Some(stem) if !stem.ends_with(['a', 'e', 'o', 'u']) => format!("{stem}ies"),
        _ => format!("{singular}s"),
    }
}

/// The word for one, or that for none and many: `is` and `are`.
pub fn either<N: Copy + PartialEq + From<u8>>(
    count: N,
    one: &'static str,
    many: &'static str,
) -> &'static str {
    if count == N::from(1) { one } else { many }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_singular_and_all_else_plural() {
        assert_eq!([counted(1_usize, "frame"), counted(0_usize, "frame")], ["1 frame", "0 frames"]);
        assert_eq!([counted(2_u64, "entry"), counted(3_i64, "key")], ["2 entries", "3 keys"]);
        assert_eq!([either(1_u32, "is", "are"), either(2_u32, "is", "are")], ["is", "are"]);
    }
}
