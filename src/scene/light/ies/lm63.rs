//! Reading LM-63 files of 1986, 1991, 1995 and 2002.
//!
//! Lines of labels and keywords, up to one that begins with `TILT=`, are passed over. `TILT=INCLUDE` is read and not
//! used: the luminaire hangs as it was measured. Of the photometric types, C is accepted. Intensities are multiplied by
//! the file's multiplier, ballast factor and ballast-lamp factor.

use crate::scene::bundle::text_of;
use crate::scene::error::{Location, SceneError, shown_number};

/// The most intensities that are read.
const VALUE_LIMIT: usize = 1_000_000;

/// What a file says, over the whole circle.
pub(super) struct Photometry {
    /// Degrees, ascending from at least 0 to at most 180; two or more.
    pub vertical: Vec<f64>,
    /// Degrees, ascending over a whole turn from 0 or 90 on; only one when all are alike.
    pub horizontal: Vec<f64>,
    /// Candelas, by horizontal and then by vertical angle.
    pub candelas: Vec<f64>,
}

/// Reads a file; `location` names it.
///
/// # Errors
/// With the line: when there is no `TILT=`, a number is missing, malformed, negative or not finite, or the angles are not ascending or
/// cover none of the ranges that the standard has; when it is of photometric type A or B.
pub(super) fn read(bytes: &[u8], location: &Location) -> Result<Photometry, SceneError> {
    let text = text_of(bytes);
    let lines: Vec<&str> = text.lines().collect();
    let tilt = lines.iter().position(|line| line.trim_start().starts_with("TILT="));
    let Some(tilt) = tilt else {
        let remedy = "give an IES file (LM-63) of a luminaire";
        return Err(SceneError::new(location, "the file has no line \"TILT=\"", remedy));
    };
    let words = lines.iter().enumerate().skip(tilt + 1).flat_map(|(line, text)| {
        let gap = |letter: char| letter == ',' || letter.is_whitespace();
        text.split(gap).filter(|word| !word.is_empty()).map(move |word| (line as u32 + 1, word))
    });
    let mut numbers = Numbers { words: words.collect::<Vec<_>>().into_iter(), line: tilt as u32 + 1, location };
    match lines[tilt].trim().trim_start_matches("TILT=").trim() {
        "NONE" => {}
        "INCLUDE" => {
            numbers.next("the lamp's orientation")?;
            let pairs = numbers.count("the number of tilt angles")?;
            numbers.list(2 * pairs, "a tilt angle or factor")?;
        }
        _ => {
            let remedy = "write TILT=NONE, which means that the luminaire hangs as it was measured";
            return Err(numbers.error("the tilt factors stand in another file", remedy));
        }
    }
    let photometry = read_photometry(&mut numbers)?;
    around(photometry, &numbers)
}

fn read_photometry(numbers: &mut Numbers<'_>) -> Result<Photometry, SceneError> {
    numbers.next("the number of lamps")?;
    numbers.next("the lumens per lamp")?;
    let multiplier = numbers.positive("the candela multiplier")?;
    let vertical = numbers.count("the number of vertical angles")?;
    let horizontal = numbers.count("the number of horizontal angles")?;
    if vertical < 2 || vertical.saturating_mul(horizontal) > VALUE_LIMIT {
        let problem = format!("there are {vertical} vertical and {horizontal} horizontal angles");
        return Err(numbers.error(problem, format!("give two vertical ones or more, and at most {VALUE_LIMIT} values")));
    }
    let kind = numbers.next("the photometric type")?;
    if kind != 1.0 {
        let name = if kind == 2.0 { "B" } else { "A" };
        let remedy = "convert it to type C";
        return Err(numbers.error(format!("photometric type {name} is not supported"), remedy));
    }
    for what in ["the unit of length", "the width", "the length", "the height"] {
        numbers.next(what)?;
    }
    let ballast = numbers.positive("the ballast factor")?;
    let lamp = numbers.positive("the ballast-lamp factor")?;
    numbers.next("the input power")?;
    let vertical = numbers.ascending(vertical, "a vertical angle")?;
    let horizontal = numbers.ascending(horizontal, "a horizontal angle")?;
    let mut candelas = numbers.list(vertical.len() * horizontal.len(), "an intensity")?;
    if candelas.iter().any(|candelas| *candelas < 0.0) {
        return Err(numbers.error("an intensity is negative", "give intensities of at least 0"));
    }
    candelas.iter_mut().for_each(|candelas| *candelas *= multiplier * ballast * lamp);
    if candelas.iter().any(|candelas| !(*candelas as f32).is_finite()) {
        return Err(numbers.error("an intensity is too large", "check the multiplier and the factors"));
    }
    Ok(Photometry { vertical, horizontal, candelas })
}

/// Completes what symmetry leaves out: 0–90° is a quarter of the circle, 0–180° and 90–270° are halves.
fn around(measured: Photometry, numbers: &Numbers<'_>) -> Result<Photometry, SceneError> {
    let Photometry { vertical, horizontal, candelas } = measured;
    if vertical[0] < 0.0 || vertical[vertical.len() - 1] > 180.0 {
        return Err(numbers.error("vertical angles lie outside of 0 to 180 degrees", "convert the file to type C"));
    }
    if horizontal.len() == 1 {
        return Ok(Photometry { vertical, horizontal, candelas });
    }
    let (first, last) = (horizontal[0], horizontal[horizontal.len() - 1]);
    let copies = match (first, last) {
        (0.0, 90.0) => 4,
        (0.0, 180.0) | (90.0, 270.0) => 2,
        (0.0, 360.0) => 1,
        _ => {
            let problem =
                format!("horizontal angles go from {} to {} degrees", shown_number(first), shown_number(last));
            return Err(numbers.error(problem, "they must go from 0 to 0, 90, 180 or 360, or from 90 to 270"));
        }
    };
    // Every other copy is mirrored. The angle at which two of them meet stands once.
    let mut columns: Vec<(f64, usize)> = Vec::new();
    for copy in 0..copies {
        let start = f64::from(copy) * (last - first);
        let forwards = horizontal.iter().enumerate().map(|(column, angle)| (start + angle, column));
        let backwards =
            horizontal.iter().enumerate().rev().map(|(column, angle)| (start + first + last - angle, column));
        match copy % 2 {
            0 => columns.extend(forwards),
            _ => columns.extend(backwards),
        }
    }
    columns.dedup_by_key(|(angle, _)| *angle);
    let rows = vertical.len();
    let all = columns.iter().flat_map(|(_, column)| candelas[column * rows..][..rows].iter().copied()).collect();
    Ok(Photometry { vertical, horizontal: columns.into_iter().map(|(angle, _)| angle).collect(), candelas: all })
}

/// The numbers after the tilt line.
struct Numbers<'a> {
    words: std::vec::IntoIter<(u32, &'a str)>,
    line: u32,
    location: &'a Location,
}

impl Numbers<'_> {
    fn error(&self, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::new(&Location { line: self.line, ..self.location.clone() }, problem, remedy)
    }

    /// The next number; `what` is what it means.
    fn next(&mut self, what: &str) -> Result<f64, SceneError> {
        let Some((line, word)) = self.words.next() else {
            return Err(self.error(format!("the file ends where {what} belongs"), "restore the file: it is cut off"));
        };
        self.line = line;
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => {
                let shown: String = word.chars().take(40).collect();
                Err(self.error(format!("{shown:?} stands where {what} belongs"), "give a finite number"))
            }
        }
    }

    fn positive(&mut self, what: &str) -> Result<f64, SceneError> {
        let number = self.next(what)?;
        if number > 0.0 {
            return Ok(number);
        }
        Err(self.error(format!("{what} is {}", shown_number(number)), "give a number above 0"))
    }

    fn count(&mut self, what: &str) -> Result<usize, SceneError> {
        let number = self.next(what)?;
        if number.fract() == 0.0 && (1.0..=1e6).contains(&number) {
            return Ok(number as usize);
        }
        Err(self.error(format!("{what} is {}", shown_number(number)), "give a whole number from 1 to 1000000"))
    }

    /// As many numbers as the file still has are reserved at most.
    fn list(&mut self, count: usize, what: &str) -> Result<Vec<f64>, SceneError> {
        if count > self.words.len() {
            let problem =
                format!("the file has {} numbers left where {count} belong ({what} and more)", self.words.len());
            return Err(self.error(problem, "restore the file: it is cut off"));
        }
        (0..count).map(|_| self.next(what)).collect()
    }

    fn ascending(&mut self, count: usize, what: &str) -> Result<Vec<f64>, SceneError> {
        let angles = self.list(count, what)?;
        if angles.windows(2).all(|pair| pair[0] < pair[1]) {
            return Ok(angles);
        }
        Err(self.error(format!("{what} is not larger than the one before"), "sort them"))
    }
}
