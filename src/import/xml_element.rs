//! The pieces of an XML file: places of elements, and the numbers in their attributes.

use roxmltree::{Document, Node};

use glam::DVec3;

use super::mitsuba_old::Version;
use super::transform;
use super::values::{self, Refusal};
use crate::scene::error::{Location, SceneError};
use crate::scene::notice::Notice;

/// One file's name and where its lines begin.
pub(super) struct File<'a> {
    name: &'a str,
    line_starts: Vec<usize>,
}

impl<'a> File<'a> {
    pub(super) fn text<'b>(bytes: &'b [u8], location: &Location) -> Result<&'b str, SceneError> {
        std::str::from_utf8(bytes).map_err(|error| {
            let line = 1 + bytes[..error.valid_up_to()].iter().filter(|byte| **byte == b'\n').count();
            let place = Location { line: line as u32, ..location.clone() };
            SceneError::new(&place, "the file is not UTF-8 text", "save it as UTF-8")
        })
    }

    pub(super) fn parse<'b>(text: &'b str, location: &Location) -> Result<Document<'b>, SceneError> {
        Document::parse(text).map_err(|error| {
            let place = Location { line: error.pos().row, ..location.clone() };
            match error {
                roxmltree::Error::DtdDetected => {
                    SceneError::new(&place, "the file has a document type (DTD)", "remove the <!DOCTYPE …>")
                }
                error => SceneError::new(&place, format!("malformed XML: {error}"), ""),
            }
        })
    }

    pub(super) fn new(name: &'a str, text: &str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self { name, line_starts: std::iter::once(0).chain(ends.map(|(position, _)| position + 1)).collect() }
    }

    pub(super) fn place(&self, node: Node<'_, '_>, path: impl Into<String>) -> Location {
        let line = self.line_starts.partition_point(|start| *start <= node.range().start);
        Location { file: self.name.to_owned(), line: line as u32, path: path.into() }
    }
}

/// The attributes of one element, with `$names` replaced.
pub(super) struct Attributes<'a>(pub(super) Vec<(&'a str, String)>);

impl Attributes<'_> {
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(known, _)| *known == name).map(|(_, value)| value.as_str())
    }

    /// A required attribute: the reader made sure that it is there.
    pub(super) fn text(&self, name: &str) -> &str {
        self.get(name).unwrap_or_default()
    }

    /// Three numbers from `value`, or from x, y and z with a default for those left out.
    pub(super) fn triple(&self, default: f64) -> Result<[f64; 3], Refusal> {
        let axes = ["x", "y", "z"].map(|axis| self.get(axis));
        match self.get("value") {
            Some(_) if axes.iter().any(Option::is_some) => {
                Err(("\"value\" and x, y, z are both given".to_owned(), "give one of them"))
            }
            Some(text) => values::triple(text),
            None if axes.iter().all(Option::is_none) => {
                Err(("no numbers are given".to_owned(), "write value=\"x, y, z\""))
            }
            None => {
                let mut numbers = [default; 3];
                for (number, text) in numbers.iter_mut().zip(axes) {
                    *number = text.map_or(Ok(default), values::float)?;
                }
                Ok(numbers)
            }
        }
    }
}

/// What to say of a rotation whose axis is not a unit vector: Mitsuba 3.9.1 does not normalize it, so that it shears and stretches.
pub(super) fn notice_of_axis(
    tag: &str,
    attributes: &Attributes<'_>,
    version: Version,
    place: &Location,
) -> Option<Notice> {
    const ROUNDING: f64 = 1e-3;
    if tag != "rotate" || version.is_old() {
        return None;
    }
    let length = DVec3::from_array(attributes.triple(0.0).ok()?).length();
    let subject = format!("a rotation about an axis of length {length:.3}");
    let explanation = "the axis counts as a direction, where Mitsuba 3 also shears and stretches by its length";
    ((length - 1.0).abs() > ROUNDING).then(|| Notice::approximated(place, subject, explanation))
}

/// The matrix of one step of a transform, whose required attributes are there.
pub(super) fn step_matrix(tag: &str, attributes: &Attributes<'_>) -> Result<glam::DMat4, Refusal> {
    let described = |problem: String| (problem, "change the numbers");
    match tag {
        "translate" => attributes.triple(0.0).map(transform::translate),
        "scale" => attributes.triple(1.0).map(transform::scale),
        "rotate" => {
            let degrees = values::float(attributes.text("angle"))?;
            transform::rotate(attributes.triple(0.0)?, degrees).map_err(described)
        }
        "lookat" => {
            let [origin, target, up] = ["origin", "target", "up"].map(|name| values::triple(attributes.text(name)));
            transform::look_at(origin?, target?, up?).map_err(described)
        }
        _ => transform::matrix(&values::floats(attributes.text("value"))?)
            .map_err(|problem| (problem, "give 16 numbers row by row, or 9")),
    }
}
