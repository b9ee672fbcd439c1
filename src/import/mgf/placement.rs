//! Transforms of MGF: `-t x y z`, `-rx`, `-ry`, `-rz` degrees, `-s` factor, `-mx`, `-my`, `-mz`, `-i` N, `-a` N.
//!
//! Arguments apply from left to right. What follows `-i N`, up to the next `-i` or `-a`, applies N times; what follows
//! `-a N` makes N copies, of which the k-th has it applied k times, k = 0 … N-1.

use glam::{DMat4, DVec3};

use super::super::transform;
use super::super::values::shown;
use super::text::Entity;
use crate::scene::error::SceneError;

/// The arguments of one transform.
pub(super) struct Placement {
    steps: Vec<Step>,
    /// The copy that is being made: the index along every `-a`, the last of which changes fastest.
    indices: Vec<u32>,
    /// How many copies there are along every `-a`.
    counts: Vec<u32>,
}

/// A matrix and how often it applies.
struct Step {
    matrix: DMat4,
    repeat: Repeat,
}

#[derive(Clone, Copy)]
enum Repeat {
    Times(u32),
    /// As often as the index of the copy says.
    Index,
}

impl Placement {
    /// Reads the arguments of `entity` from `first` on.
    pub(super) fn read(entity: &Entity<'_>, first: usize) -> Result<Self, SceneError> {
        let mut steps = vec![Step { matrix: DMat4::IDENTITY, repeat: Repeat::Times(1) }];
        let mut counts: Vec<u32> = Vec::new();
        let mut at = first;
        while at < entity.words.len() {
            let flag = entity.word(at);
            let arguments = if let "-i" | "-a" = flag {
                let count = count(entity, at + 1, u32::from(flag == "-a"))?;
                let repeat = if flag == "-i" { Repeat::Times(count) } else { Repeat::Index };
                counts.extend((flag == "-a").then_some(count));
                steps.push(Step { matrix: DMat4::IDENTITY, repeat });
                1
            } else {
                let (matrix, arguments) = motion(entity, at)?;
                if let Some(step) = steps.last_mut() {
                    step.matrix = matrix * step.matrix;
                }
                arguments
            };
            at += 1 + arguments;
        }
        Ok(Self { steps, indices: vec![0; counts.len()], counts })
    }

    /// How many copies it makes; 1 without an array.
    pub(super) fn copies(&self) -> u64 {
        self.counts.iter().fold(1, |copies, count| copies.saturating_mul(u64::from(*count)))
    }

    /// The matrix of the copy that is being made.
    pub(super) fn matrix(&self) -> DMat4 {
        let mut indices = self.indices.iter();
        self.steps.iter().fold(DMat4::IDENTITY, |matrix, step| {
            let times = match step.repeat {
                Repeat::Times(times) => times,
                Repeat::Index => indices.next().copied().unwrap_or_default(),
            };
            power(step.matrix, times) * matrix
        })
    }

    /// Goes on to the next copy; false after the last.
    pub(super) fn advance(&mut self) -> bool {
        for (index, count) in self.indices.iter_mut().zip(&self.counts).rev() {
            *index += 1;
            if *index < *count {
                return true;
            }
            *index = 0;
        }
        false
    }
}

fn count(entity: &Entity<'_>, at: usize, least: u32) -> Result<u32, SceneError> {
    let word = entity.word(at);
    word.parse().ok().filter(|count| *count >= least).ok_or_else(|| {
        entity.error(format!("{} is not a count", shown(word)), format!("give a whole number of at least {least}"))
    })
}

/// The matrix of the flag at `at`, and how many arguments it has.
fn motion(entity: &Entity<'_>, at: usize) -> Result<(DMat4, usize), SceneError> {
    let turn = |axis: DVec3| {
        let degrees = entity.number(at + 1)?;
        let matrix = transform::rotate(axis.to_array(), degrees);
        matrix.map_err(|problem| entity.error(problem, "change the numbers")).map(|matrix| (matrix, 1))
    };
    let mirror = |axis: DVec3| (DMat4::from_scale(DVec3::ONE - 2.0 * axis), 0);
    let flag = entity.word(at);
    Ok(match flag {
        "-t" => (DMat4::from_translation(entity.triple(at + 1)?), 3),
        "-rx" => turn(DVec3::X)?,
        "-ry" => turn(DVec3::Y)?,
        "-rz" => turn(DVec3::Z)?,
        "-s" => match entity.number(at + 1)? {
            0.0 => return Err(entity.error("the scale is 0", "give a factor that is not 0")),
            factor => (DMat4::from_scale(DVec3::splat(factor)), 1),
        },
        "-mx" => mirror(DVec3::X),
        "-my" => mirror(DVec3::Y),
        "-mz" => mirror(DVec3::Z),
        _ => {
            let remedy = "transforms are made of -t x y z, -rx, -ry, -rz degrees, -s factor, -mx, -my, -mz, -i N, -a N";
            return Err(entity.error(format!("there is no transform {}", shown(flag)), remedy));
        }
    })
}

/// `matrix` applied `times` times.
fn power(matrix: DMat4, times: u32) -> DMat4 {
    let (mut result, mut square, mut left) = (DMat4::IDENTITY, matrix, times);
    while left > 0 {
        if left & 1 == 1 {
            result *= square;
        }
        square *= square;
        left >>= 1;
    }
    result
}
