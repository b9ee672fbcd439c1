//! Edits that make a case of a scene: bits, cuts, splices, tokens that come again, numbers that nobody expects.

use std::ops::Range;

use crate::corpus::{Format, Sample};

/// What takes the place of numbers in text.
const NUMBERS: [&[u8]; 18] = [
    b"0",
    b"-1",
    b"1",
    b"2",
    b"0.5",
    b"nan",
    b"inf",
    b"1e308",
    b"-1e308",
    b"1e39",
    b"1e-320",
    b"65536",
    b"1000000",
    b"1e9",
    b"2147483648",
    b"4294967296",
    b"9007199254740993",
    b"18446744073709551616",
];

/// What takes the place of four bytes in binary files.
const WORDS: [u32; 10] =
    [0, 1, 0xff, 0xffff, 0x10_0000, 0x7fff_ffff, 0x8000_0000, u32::MAX, f32::NAN.to_bits(), f32::MAX.to_bits()];

/// Numbers that depend on the seed alone (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound.max(1) as u64) as usize
    }

    fn pick<'a, T>(&mut self, items: &'a [T]) -> Option<&'a T> {
        items.get(self.below(items.len()))
    }

    /// A place for a range of at most `most` bytes.
    fn range(&mut self, length: usize, most: usize) -> Range<usize> {
        let start = self.below(length);
        start..(start + 1 + self.below(most)).min(length)
    }
}

/// Case `number` of a format: one of its samples with one to four edits.
pub(crate) fn mutate(format: &Format, number: u64) -> Sample {
    let mut numbers = Numbers(number.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let mut sample = format.samples[numbers.below(format.samples.len())].clone();
    for _ in 0..=numbers.below(4) {
        // The scene itself, or any of its files.
        let scene = format.name != "files" && numbers.below(3) > 0;
        let file = if scene { 0 } else { numbers.below(sample.files.len()) };
        let donors = &format.samples[numbers.below(format.samples.len())].files;
        let donor = &donors[numbers.below(donors.len())].1;
        edit(&mut sample.files[file].1, donor, &mut numbers);
    }
    sample
}

fn edit(bytes: &mut Vec<u8>, donor: &[u8], numbers: &mut Numbers) {
    let place = numbers.below(bytes.len());
    if bytes.is_empty() {
        return;
    }
    match numbers.below(12) {
        0 => bytes[place] ^= 1 << numbers.below(8),
        1 => bytes[place] = b"0-9$.\"'<>{}[]/#,:\n e\0\xff"[numbers.below(22)],
        2 if numbers.below(3) == 0 => bytes.truncate(place),
        2 => drop(bytes.drain(numbers.range(bytes.len(), 40))),
        3 => drop(bytes.splice(place..place, donor[numbers.range(donor.len(), 400)].iter().copied())),
        4 => {
            let word = *numbers.pick(&WORDS).unwrap_or(&0);
            bytes.iter_mut().skip(place / 4 * 4).zip(word.to_le_bytes()).for_each(|(byte, new)| *byte = new);
        }
        5 | 6 => repeat(bytes, numbers),
        7 => exchange(bytes, numbers),
        _ => replace_number(bytes, numbers),
    }
}

/// Lets a word, a line or any piece come again, sometimes very often.
fn repeat(bytes: &mut Vec<u8>, numbers: &mut Numbers) {
    let piece = match numbers.below(3) {
        0 => numbers.pick(&tokens(bytes, |byte| byte != b'\n')).cloned(),
        1 => numbers.pick(&tokens(bytes, |byte| !byte.is_ascii_whitespace())).cloned(),
        _ => Some(numbers.range(bytes.len(), 60)),
    };
    let Some(piece) = piece else { return };
    let times = if numbers.below(8) == 0 { 300 } else { 1 };
    let copies = bytes[piece.clone()].repeat(times);
    let place = if numbers.below(2) == 0 { piece.end } else { numbers.below(bytes.len()) };
    bytes.splice(place..place, copies);
}

/// Puts a copy of a word in place of another.
fn exchange(bytes: &mut Vec<u8>, numbers: &mut Numbers) {
    let words = tokens(bytes, |byte| byte.is_ascii_alphanumeric() || byte == b'_');
    let (Some(from), Some(to)) = (numbers.pick(&words), numbers.pick(&words)) else { return };
    let word = bytes[from.clone()].to_vec();
    bytes.splice(to.clone(), word);
}

fn replace_number(bytes: &mut Vec<u8>, numbers: &mut Numbers) {
    let mut places = tokens(bytes, |byte| byte.is_ascii_digit() || b"+-.eE".contains(&byte));
    places.retain(|place| bytes[place.clone()].iter().any(u8::is_ascii_digit));
    let (Some(place), Some(number)) = (numbers.pick(&places), numbers.pick(&NUMBERS)) else { return };
    bytes.splice(place.clone(), number.iter().copied());
}

/// The longest runs of bytes that belong.
fn tokens(bytes: &[u8], belongs: impl Fn(u8) -> bool) -> Vec<Range<usize>> {
    let mut start = 0;
    let runs = bytes.split(|byte| !belongs(*byte)).map(|run| {
        let range = start..start + run.len();
        start = range.end + 1;
        range
    });
    runs.filter(|range| !range.is_empty()).collect()
}
