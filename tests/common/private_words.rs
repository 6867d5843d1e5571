//! Words that the window once had for what everybody in the field calls otherwise. Each has a usual name now.

/// Phrases that no text for people holds.
const PHRASES: [&str; 59] = [
    "Who won",
    "who won",
    "stands for",
    "stand for whom",
    "Sees it?",
    "looks past it",
    "at its seam",
    "not as long",
    "Paint",
    "Painting",
    "paints",
    "painted",
    "painting",
    "Pushpull",
    "Across spans",
    "Cosine floor",
    "Noise ×",
    "Redundancy over time",
    "vantage",
    "Stand where",
    "In motion",
    "dB apart",
    "steps on average",
    "by one side alone",
    "dB by pruning",
    "background kept",
    "not hold for all",
    "bars show what",
    "k samples show it",
    "Go on",
    "on now",
    "put it on",
    "lossless by both axes",
    "frame times anew",
    "of 100 within",
    "Time passed",
    "Processor",
    "processor",
    "graphics card",
    "Pictures per leg",
    "per leg",
    "Keep these settings",
    "Your own",
    "wrong clock",
    "argument",
    "Show the keys",
    "this sheet",
    "Close keys",
    "take back a change",
    "do it again",
    "looked at",
    "let go of",
    "keep the pixel",
    "Rerun",
    "Nothing of that name",
    "Show the orrery",
    "Open anyway",
    "Close anyway",
    "Saved file",
];

/// Texts that are nothing but this: within a sentence some of these words are what everybody says.
const WHOLE_TEXTS: [&str; 17] = [
    "There",
    "Rate",
    "Steps",
    "Brighter",
    "Thresholds",
    "Levels",
    "Tree",
    "Overlap",
    "Mixed pixels",
    "Yield",
    "Gather",
    "Along",
    "Stability",
    "Meter",
    "Film",
    "Careful",
    "Bold",
];

/// The private word in a text for people, if it has one.
pub(crate) fn private_word(text: &str) -> Option<&'static str> {
    let is_letter = |letter: Option<char>| letter.is_some_and(char::is_alphanumeric);
    let holds = |phrase: &&&str| {
        text.match_indices(**phrase).any(|(at, _)| {
            let after = &text[at + phrase.len()..];
            !is_letter(text[..at].chars().next_back()) && !is_letter(after.chars().next())
        })
    };
    let phrase = PHRASES.iter().find(holds);
    phrase.or_else(|| WHOLE_TEXTS.iter().find(|whole| **whole == text.trim())).copied()
}
