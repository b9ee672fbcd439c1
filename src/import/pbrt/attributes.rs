//! What is current: transform, material, area light, orientation.

use glam::{DAffine3, DMat4};

use super::super::motion::between;
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
    /// At the start and at the end of a motion.
    transforms: [DMat4; 2],
    /// To which of both the next transforms apply.
    active: [bool; 2],
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
    /// When motions start and end.
    pub times: [f64; 2],
    /// The moment that is shown; without one, the start.
    moment: Option<f64>,
    /// Whether anything that was placed so far moves.
    pub moves: bool,
}

impl Attributes {
    /// Those at the beginning of a file of which `moment` is shown.
    pub(super) fn new(moment: Option<f64>) -> Self {
        let current = Surface {
            transforms: [DMat4::IDENTITY; 2],
            active: [true; 2],
            material: None,
            light: None,
            reverse: false,
            media: [None, None],
        };
        Self { current, saved: Vec::new(), times: [0.0, 1.0], moment, moves: false }
    }

    /// Where something stands that is placed now.
    pub(super) fn transform(&mut self) -> DMat4 {
        self.at_moment(self.current.transforms)
    }

    /// From the world to a camera that is placed now. pbrt moves cameras in the world, not the world before them.
    pub(super) fn camera_transform(&mut self) -> DMat4 {
        let [start, end] = self.current.transforms;
        if start == end { start } else { inverse(self.at_moment([start, end].map(inverse))) }
    }

    fn at_moment(&mut self, [start, end]: [DMat4; 2]) -> DMat4 {
        self.moves |= start != end;
        let [first, last] = self.times;
        let share = self.moment.map_or(0.0, |moment| (moment - first) / (last - first));
        between(start, end, share.clamp(0.0, 1.0))
    }

    /// The current transforms at the start and at the end of a motion.
    pub(super) fn transforms(&self) -> [DMat4; 2] {
        self.current.transforms
    }

    /// Begins the world, in which nothing is moved yet.
    pub(super) fn begin_world(&mut self) {
        (self.current.transforms, self.current.active) = ([DMat4::IDENTITY; 2], [true; 2]);
    }

    /// Replaces both current transforms.
    pub(super) fn set_transforms(&mut self, transforms: [DMat4; 2]) {
        self.current.transforms = transforms;
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
                        (self.current.transforms, self.current.active) = (saved.transforms, saved.active);
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
                self.current.active = match tokens.next()? {
                    Some(Token::Word("StartTime")) => [true, false],
                    Some(Token::Word("EndTime")) => [false, true],
                    Some(Token::Word("All")) => [true, true],
                    _ => return Err(refused("it is neither StartTime, EndTime nor All".to_owned())),
                };
                return Ok(true);
            }
            "Identity" => DMat4::IDENTITY,
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
        let is_alone = matches!(directive, "Transform" | "Identity");
        for (transform, _) in self.current.transforms.iter_mut().zip(self.current.active).filter(|(_, active)| *active)
        {
            *transform = if is_alone { step } else { *transform * step };
            let usable = transform.is_finite() && transform.determinant().is_normal();
            if !usable || transform.row(3) != glam::DVec4::W {
                return Err(refused("the transform flattens, explodes, or has a perspective".to_owned()));
            }
        }
        Ok(true)
    }
}

/// The inverse of an affine transform, whose last row is exactly 0 0 0 1.
pub(super) fn inverse(transform: DMat4) -> DMat4 {
    DMat4::from(DAffine3::from_mat4(transform).inverse())
}

/// Numbers, in brackets or not.
pub(super) fn numbers<const N: usize>(tokens: &mut Tokens<'_>, place: &Location) -> Result<[f64; N], SceneError> {
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
