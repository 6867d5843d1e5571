//! Which part of a file's name numbers its frame: found over all cameras together.
//!
//! A name holds several numbers as a rule, of the camera, the channel or the take. The one that numbers frames differs within each
//! camera, and is the same in all of them.

use std::collections::{BTreeMap, BTreeSet};

use super::files::path_without_extension;
use super::manifest::PictureEntry;

/// A number in a name: whole, or with a fraction behind a point, in units of 10⁻⁹.
type NameNumber = u128;

/// One whole unit of a [`NameNumber`].
const WHOLE: NameNumber = 1_000_000_000;
/// Larger numbers are times, not frames: seconds since 1970 have ten digits.
const LARGEST_FRAME: NameNumber = 1_000_000_000;

/// One number of each picture, which no two pictures of a camera share.
pub(super) struct NumbersInNames<'a> {
    numbers: Vec<NameNumber>,
    /// Those of each camera, by its name; cameras in order of appearance.
    pub(super) by_camera: Vec<(&'a str, BTreeSet<NameNumber>)>,
}

impl<'a> NumbersInNames<'a> {
    /// The numbers that number frames; `None` where names hold none that tells the pictures of each camera apart, or no camera has
    /// several pictures. Those that all cameras have alike come first, then those that some share; at the end of names before others.
    pub(super) fn find(entries: &[PictureEntry], cameras: &'a [String]) -> Option<Self> {
        let names: Vec<&str> = entries.iter().map(|entry| path_without_extension(&entry.file_path)).collect();
        let mut found = Vec::new();
        for has_fractions in [true, false] {
            let runs: Vec<Vec<NameNumber>> =
                names.iter().map(|name| numbers_of(name, has_fractions)).collect();
            let most = runs.iter().map(Vec::len).min().unwrap_or(0);
            for nth in 0..most {
                let from_end = runs.iter().map(|runs| runs[runs.len() - 1 - nth]).collect();
                let from_start = runs.iter().map(|runs| runs[nth]).collect();
                found.extend([from_end, from_start].into_iter().filter_map(|it| Self::of(it, cameras)));
            }
            // A fraction counts where whole parts differ as well: `1.0003` may be the third frame of camera 1.
            if has_fractions {
                found.retain(|numbers: &Self| numbers.are_same() && numbers.whole_parts_differ());
            }
        }
        let rank = |numbers: &Self| (!numbers.are_same(), numbers.are_disjoint());
        found.into_iter().min_by_key(rank)
    }

    fn of(numbers: Vec<NameNumber>, cameras: &'a [String]) -> Option<Self> {
        let mut index_of: BTreeMap<&str, usize> = BTreeMap::new();
        let mut by_camera: Vec<(&str, BTreeSet<NameNumber>)> = Vec::new();
        for (camera, number) in cameras.iter().zip(&numbers) {
            let index = *index_of.entry(camera).or_insert(by_camera.len());
            if index == by_camera.len() {
                by_camera.push((camera, BTreeSet::new()));
            }
            if !by_camera[index].1.insert(*number) {
                return None;
            }
        }
        let is_any = by_camera.iter().any(|(_, numbers)| numbers.len() > 1);
        is_any.then_some(Self { numbers, by_camera })
    }

    /// Whether all cameras have the same numbers.
    pub(super) fn are_same(&self) -> bool {
        let first = self.by_camera.first().map(|(_, numbers)| numbers);
        self.by_camera.iter().all(|(_, numbers)| Some(numbers) == first)
    }

    /// Whether no two cameras have a number in common.
    pub(super) fn are_disjoint(&self) -> bool {
        let count: usize = self.by_camera.iter().map(|(_, numbers)| numbers.len()).sum();
        count == self.all().len()
    }

    /// A camera that lacks a number which others have, and the number.
    pub(super) fn missing(&self) -> Option<(&'a str, u128)> {
        let all = self.all();
        let lacks = |(camera, numbers): &(&'a str, BTreeSet<NameNumber>)| {
            Some((*camera, all.difference(numbers).next()? / WHOLE))
        };
        self.by_camera.iter().find_map(lacks)
    }

    /// The number of each picture's frame. Numbers without gaps are counted from 0; others of frames are kept with their gaps, and
    /// times become their order within the camera.
    pub(super) fn frames(&self, cameras: &[String]) -> Vec<i64> {
        let all = self.all();
        let (first, last) = (all.first().copied().unwrap_or(0), all.last().copied().unwrap_or(0));
        let are_frames =
            self.are_same() && all.iter().all(|it| it % WHOLE == 0) && last < LARGEST_FRAME * WHOLE;
        let is_gapless = (last - first) / WHOLE + 1 == all.len() as u128;
        if are_frames && !is_gapless {
            return self.numbers.iter().map(|number| (number / WHOLE) as i64).collect();
        }
        let sets: BTreeMap<&str, &BTreeSet<NameNumber>> =
            self.by_camera.iter().map(|(camera, numbers)| (*camera, numbers)).collect();
        let rank = |(camera, number): (&String, &NameNumber)| {
            sets.get(camera.as_str()).map_or(0, |numbers| numbers.range(..number).count() as i64)
        };
        cameras.iter().zip(&self.numbers).map(rank).collect()
    }

    fn all(&self) -> BTreeSet<NameNumber> {
        self.by_camera.iter().flat_map(|(_, numbers)| numbers).copied().collect()
    }

    fn whole_parts_differ(&self) -> bool {
        self.all().iter().map(|number| number / WHOLE).collect::<BTreeSet<_>>().len() > 1
    }
}

/// The runs of digits in a name; with fractions, digits on both sides of a point are one number.
fn numbers_of(name: &str, has_fractions: bool) -> Vec<NameNumber> {
    let mut numbers = Vec::new();
    let mut rest = name;
    while let Some(start) = rest.find(|letter: char| letter.is_ascii_digit()) {
        rest = &rest[start..];
        let end = |text: &str| text.find(|letter: char| !letter.is_ascii_digit()).unwrap_or(text.len());
        let whole = end(rest);
        // Longer runs are no numbers of frames, but names of things.
        let mut number = rest[..whole].parse::<u64>().map_or(0, u128::from) * WHOLE;
        rest = &rest[whole..];
        if let Some(behind) = rest.strip_prefix('.').filter(|_| has_fractions)
            && end(behind) > 0
        {
            let digits = &behind[..end(behind)];
            number += format!("{digits:0<9.9}").parse::<u128>().unwrap_or(0);
            rest = &behind[digits.len()..];
        }
        numbers.push(number);
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(names: &[(&str, &str)]) -> Option<Vec<i64>> {
        let entry = |(_, name): &(&str, &str)| PictureEntry {
            file_path: (*name).to_owned(),
            ..PictureEntry::default()
        };
        let entries: Vec<PictureEntry> = names.iter().map(entry).collect();
        let cameras: Vec<String> = names.iter().map(|(camera, _)| (*camera).to_owned()).collect();
        let found = NumbersInNames::find(&entries, &cameras)?;
        Some(found.frames(&cameras))
    }

    #[test]
    fn the_number_of_the_frame_is_found_wherever_it_stands() {
        let patterns: [fn(&str, u32) -> String; 6] = [
            |camera, number| format!("{camera}/{number:04}_rgb.png"),
            |camera, number| format!("frame_{number}_{camera}.png"),
            |camera, number| format!("{number:03}/{camera}"),
            |camera, number| format!("{camera}.{number:04}.beauty2.exr"),
            |camera, number| format!("take7/{camera}/{number}.png"),
            |camera, number| format!("{camera}_{:.6}_8bit.png", 12.5 * f64::from(number)),
        ];
        for pattern in patterns {
            let listed = [("1", 10), ("1", 1), ("2", 1), ("2", 10), ("left", 10), ("left", 1)];
            let names = listed.map(|(camera, number)| (camera, pattern(camera, number)));
            let names: Vec<(&str, &str)> = names.iter().map(|(camera, name)| (*camera, &**name)).collect();
            let found = frames(&names).unwrap();
            let [first, last] = [found[1], found[0]];
            assert!(first < last, "{names:?}");
            assert_eq!(found, [last, first, first, last, last, first], "{names:?}");
        }
    }

    #[test]
    fn gaps_are_kept_and_times_are_ranked() {
        let of = |names: [&str; 3]| frames(&names.map(|name| ("a", name))).unwrap();
        assert_eq!(of(["1005.exr", "1001.exr", "1002.exr"]), [1005, 1001, 1002]);
        assert_eq!(of(["3.exr", "1.exr", "2.exr"]), [2, 0, 1]);
        assert_eq!(of(["1305031102.5.png", "1305031102.25.png", "1305031103.0.png"]), [1, 0, 2]);
        assert!(frames(&[("a", "x.png"), ("a", "y.png")]).is_none());
        assert!(frames(&[("a", "1.png"), ("b", "2.png")]).is_none());
    }

    #[test]
    fn cameras_with_stamps_of_their_own_are_paired_in_the_order_of_these() {
        let found = frames(&[("a", "a/171"), ("a", "a/102"), ("b", "b/113"), ("b", "b/184")]);
        assert_eq!(found.unwrap(), [1, 0, 0, 1]);
    }
}
