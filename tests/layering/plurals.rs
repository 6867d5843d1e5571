//! No text says "1 frames": counts and their nouns go through `plural`.

use super::{code, sources};

/// Nouns that are counted somewhere, without the s of their plural.
const NOUNS: &str = "baseline block byte camera candidate capture change channel chunk context entrie file frame hole image item key level \
    line marker method number picture pixel place point pose row run sample second setting source span step store table \
    thread tile trial value view viewpoint warning";

/// Where a count is never 1, or nobody reads it: limits that were passed, several captures, what tells one journal from another.
const NEVER_ONE: [&str; 15] = [
    "bytes are too many",
    "All {captures} captures together",
    "All {count} points on the Pareto front",
    "{:08x} of {files} files",
    "\"{}; {} threads; {}\"",
    "{} {:?} {source}; {} frames",
    "{count} tiles of samples at one frame",
    "{most} cameras can be gathered from",
    "have {pixels} pixels together",
    "a chunk of {bytes} bytes",
    "each of {poses} poses became one",
    "{count} pictures show none of the views",
    "its {what} pictures are",
    "({each} bytes each)",
    "{} dB over",
];

/// Whether text that ends here ends with a count that may be 1: a placeholder of a whole number, or the digit itself.
fn ends_with_count(text: &str) -> bool {
    if let Some(head) = text.strip_suffix('1') {
        return head.ends_with([' ', '"', '(']);
    }
    let Some((before, inside)) = text.strip_suffix('}').and_then(|text| text.rsplit_once('{')) else {
        return false;
    };
    // Numbers with decimals are plural in any case, constants are known, and a size is written as 640×480 pixels.
    let has_decimals = inside.contains(":.") && !inside.contains(":.0");
    let is_constant = inside.chars().all(|letter| letter.is_ascii_uppercase() || letter == '_');
    !before.ends_with('×') && !has_decimals && (inside.is_empty() || !is_constant)
}

/// The noun of a line that stands in the plural behind a count.
fn escaped(line: &str) -> Option<&'static str> {
    NOUNS.split_whitespace().find(|noun| {
        let plural = format!(" {noun}s");
        line.match_indices(&plural).any(|(at, _)| {
            let goes_on = line[at + plural.len()..].starts_with(|next: char| next.is_alphanumeric());
            !goes_on && ends_with_count(&line[..at])
        })
    })
}

#[test]
fn no_text_counts_one_in_the_plural() {
    let mut found = Vec::new();
    for (name, text) in sources() {
        let shown = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
        for (index, line) in code(shown).enumerate() {
            let is_known = NEVER_ONE.iter().any(|known| line.contains(known));
            if let Some(noun) = escaped(line).filter(|_| !is_known) {
                found.push(format!("src/{name}:{}: {noun}: {}", index + 1, line.trim()));
            }
        }
    }
    assert!(found.is_empty(), "use plural::counted in\n{}", found.join("\n"));
}

#[test]
fn what_would_count_one_in_the_plural_is_found() {
    assert_eq!(escaped("format!(\"{frames} frames\")"), Some("frame"));
    assert_eq!(escaped("\"kept 1 samples\""), Some("sample"));
    assert_eq!(
        escaped("\"{:.1} steps, {width}×{height} pixels, {MOST} views, 21 keys, {count} framesets\""),
        None
    );
}
