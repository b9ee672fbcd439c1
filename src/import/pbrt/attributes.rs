//! What is current: transform, material, area light, orientation.

use glam::{DAffine3, DMat4};

use super::super::transform;
use super::super::values::shown;
use super::light::AreaSource;
use super::material::Material;
use super::medium::MediumId;
use super::text::{Token, Tokens};
use crate::scene::error::{Location, SceneError};

/// How deep attributes may nest.
const DEPTH_LIMIT: usize = 1000;

/// What shapes get that come next.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    transform: DMat4,
    /// Whether transforms apply to the start of a motion, which is what is imported.
    at_start: bool,
    pub material: Option<Material>,
    /// What shapes emit.
    pub light: Option<AreaSource>,
    /// Whether the outside is turned round.
    pub reverse: bool,
    /// The media inside and outside of shapes; the camera stands in the one outside.
    pub media: [MediumId; 2],
}

/// What is current, and what comes back when a block ends.
pub(super) struct Attributes {
    pub current: Surface,
    /// With the directive that brings each back.
    saved: Vec<(Surface, &'static str)>,
}

impl Default for Attributes {
    fn default() -> Self {
        let current = Surface {
            transform: DMat4::IDENTITY,
            at_start: true,
            material: None,
            light: None,
            reverse: false,
            media: [None, None],
        };
        Self { current, saved: Vec::new() }
    }
}

impl Attributes {
    /// The current transform.
    pub(super) fn transform(&self) -> DMat4 {
        self.current.transform
    }

    /// Replaces the current transform.
    pub(super) fn set_transform(&mut self, transform: DMat4) {
        if self.current.at_start {
            self.current.transform = transform;
        }
    }

    /// How many blocks are open.
    pub(super) fn depth(&self) -> usize {
        self.saved.len()
    }

    /// Begins a block that `end` ends.
    pub(super) fn push(&mut self, place: &Location, end: &'static str) -> Result<(), SceneError> {
        if self.saved.len() >= DEPTH_LIMIT {
            let problem = format!("attributes nest more than {DEPTH_LIMIT} deep");
            return Err(SceneError::new(place, problem, format!("end them with {end}")));
        }
        self.saved.push((self.current.clone(), end));
        Ok(())
    }

    /// Ends the block that `end` ends.
    pub(super) fn pop(&mut self, place: &Location, end: &str) -> Result<(), SceneError> {
        match self.saved.pop() {
            Some((saved, known)) if known == end => {
                match end {
                    "TransformEnd" => {
                        (self.current.transform, self.current.at_start) = (saved.transform, saved.at_start);
                    }
                    _ => self.current = saved,
                }
                Ok(())
            }
            Some((_, known)) => Err(SceneError::new(place, format!("{known} must come before it"), "nest blocks")),
            None => Err(SceneError::new(place, "nothing is open that it ends", "remove it")),
        }
    }

    /// Follows a directive that changes nothing but these; false for others.
    pub(super) fn follow(
        &mut self,
        directive: &str,
        tokens: &mut Tokens<'_>,
        place: &Location,
    ) -> Result<bool, SceneError> {
        let refused = |problem: String| SceneError::new(place, problem, "check its numbers");
        let step = match directive {
            "AttributeBegin" => return self.push(place, "AttributeEnd").map(|()| true),
            "TransformBegin" => return self.push(place, "TransformEnd").map(|()| true),
            "AttributeEnd" | "TransformEnd" => return self.pop(place, directive).map(|()| true),
            "ReverseOrientation" => {
                self.current.reverse = !self.current.reverse;
                return Ok(true);
            }
            "ActiveTransform" => {
                self.current.at_start = match tokens.next()? {
                    Some(Token::Word("StartTime" | "All")) => true,
                    Some(Token::Word("EndTime")) => false,
                    _ => return Err(refused("it is neither StartTime, EndTime nor All".to_owned())),
                };
                return Ok(true);
            }
            "Identity" => {
                self.set_transform(DMat4::IDENTITY);
                return Ok(true);
            }
            "Translate" => transform::translate(numbers(tokens, place)?),
            "Scale" => transform::scale(numbers(tokens, place)?),
            "Rotate" => {
                let [angle, x, y, z] = numbers(tokens, place)?;
                transform::rotate([x, y, z], angle).map_err(refused)?
            }
            "LookAt" => {
                let [a, b, c, d, e, f, g, h, i] = numbers(tokens, place)?;
                inverse(transform::look_at([a, b, c], [d, e, f], [g, h, i]).map_err(refused)?)
            }
            "Transform" | "ConcatTransform" => {
                // Column by column.
                DMat4::from_cols_array(&numbers::<16>(tokens, place)?)
            }
            _ => return Ok(false),
        };
        let transform = if directive == "Transform" { step } else { self.current.transform * step };
        let usable = transform.is_finite() && transform.determinant().is_normal();
        if !usable || transform.row(3) != glam::DVec4::W {
            return Err(refused("the transform flattens, explodes, or has a perspective".to_owned()));
        }
        self.set_transform(transform);
        Ok(true)
    }
}

/// The inverse of an affine transform, whose last row is exactly 0 0 0 1.
pub(super) fn inverse(transform: DMat4) -> DMat4 {
    DMat4::from(DAffine3::from_mat4(transform).inverse())
}

/// Numbers, in brackets or not.
fn numbers<const N: usize>(tokens: &mut Tokens<'_>, place: &Location) -> Result<[f64; N], SceneError> {
    let error = |problem: String| SceneError::new(place, problem, format!("write {N} numbers"));
    let bracketed = tokens.next_if_open();
    let mut all = [0.0; N];
    for number in &mut all {
        *number = match tokens.next()? {
            Some(Token::Word(word)) => match word.parse::<f64>() {
                Ok(number) if number.is_finite() => number,
                _ => return Err(error(format!("{} is not a finite number", shown(word)))),
            },
            Some(other) => return Err(error(format!("{} is not a number", other.shown()))),
            None => return Err(error("the file ends here".to_owned())),
        };
    }
    if bracketed && tokens.next()? != Some(Token::Close) {
        return Err(error("\"]\" is missing".to_owned()));
    }
    Ok(all)
}
