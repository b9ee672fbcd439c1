//! Animations: where nodes stand at a moment. Only the first animation of a file is played; others are usually other takes.

use std::collections::BTreeMap;

use glam::{DQuat, DVec4};

use super::super::motion::turned;
use super::accessor::Accessor;
use super::entry::Entry;
use super::{Input, Output};
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

/// What an animation gives of a node in place of what the node says itself.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pose {
    pub translation: Option<[f64; 3]>,
    /// A quaternion (x, y, z, w).
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
}

/// The poses of nodes, by their index, at a moment.
#[derive(Debug, Default)]
pub(super) struct Poses {
    nodes: BTreeMap<usize, Pose>,
    /// From which moment to which the animation lasts, seconds.
    pub span: Option<[f64; 2]>,
}

impl Poses {
    /// Poses at `moment`. Without one every node stands where it rests, and an animation that cannot be read does not matter.
    ///
    /// # Errors
    /// On animations that lead nowhere or whose times do not rise.
    pub(super) fn read(input: &Input<'_>, moment: Option<f64>, output: &mut Output) -> Result<Self, SceneError> {
        let animations = input.document.root().objects("animations")?;
        let Some(first) = animations.first() else { return Ok(Self::default()) };
        let file = input.document.root().location();
        if let Some(moment) = moment {
            if animations.len() > 1 {
                let explanation = "its first one is played";
                output.notices.add(Notice::ignored(&file, "all animations of the file but one", explanation));
            }
            return Self::at(input, first, moment, output);
        }
        let explanation = "every node stands where it rests; --time shows a moment of the first, --frames all of it";
        output.notices.add(Notice::ignored(&file, "the animations", explanation));
        let span = Self::at(input, first, 0.0, output).ok().and_then(|poses| poses.span);
        Ok(Self { nodes: BTreeMap::new(), span })
    }

    /// The pose of a node.
    pub(super) fn of(&self, node: usize) -> Pose {
        self.nodes.get(&node).copied().unwrap_or_default()
    }

    fn at(input: &Input<'_>, animation: &Entry<'_>, moment: f64, output: &mut Output) -> Result<Self, SceneError> {
        let mut poses = Self::default();
        let samplers = animation.objects("samplers")?;
        for channel in animation.objects("channels")? {
            let Some(target) = channel.child("target")? else { continue };
            let Some((node, _)) = target.reference("node", "nodes")? else { continue };
            let sampler = samplers.get(channel.required_integer("sampler")?);
            let sampler = sampler.ok_or_else(|| channel.error("there is no such sampler", "export the scene again"))?;
            let pose = poses.nodes.entry(node).or_default();
            let span = match target.text("path")?.unwrap_or_default() {
                "translation" => Track::open(input, sampler, "VEC3")?.sample(moment, &mut pose.translation, straight),
                "scale" => Track::open(input, sampler, "VEC3")?.sample(moment, &mut pose.scale, straight),
                "rotation" => Track::open(input, sampler, "VEC4")?.sample(moment, &mut pose.rotation, along_arc),
                other => {
                    let subject = format!("the animation of {other}");
                    output.notices.add(Notice::ignored(&target.location(), subject, "only nodes move"));
                    continue;
                }
            };
            let [start, end] = poses.span.unwrap_or(span);
            poses.span = Some([start.min(span[0]), end.max(span[1])]);
        }
        Ok(poses)
    }
}

fn straight(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * share)
}

fn along_arc(a: [f64; 4], b: [f64; 4], share: f64) -> [f64; 4] {
    let unit = |turn: [f64; 4]| DQuat::from_vec4(DVec4::from_array(turn).normalize_or(DVec4::W));
    turned(unit(a), unit(b), share).to_array()
}

/// How values go from one key frame to the next.
#[derive(Clone, Copy, PartialEq)]
enum Interpolation {
    Linear,
    Step,
    Cubic,
}

/// A sampler: values by time.
struct Track<'a> {
    times: Vec<f64>,
    values: Accessor<'a>,
    interpolation: Interpolation,
}

impl<'a> Track<'a> {
    fn open(input: &Input<'a>, sampler: &Entry<'_>, kind: &str) -> Result<Self, SceneError> {
        let accessor = |key: &str, kind: &str| match sampler.reference(key, "accessors")? {
            Some((_, accessor)) => Accessor::open(input.buffers, &accessor, kind),
            None => Err(sampler.error(format!("the sampler has no {key}"), "export the scene again")),
        };
        let (input, values) = (accessor("input", "SCALAR")?, accessor("output", kind)?);
        let interpolation = match sampler.text("interpolation")?.unwrap_or("LINEAR") {
            "LINEAR" => Interpolation::Linear,
            "STEP" => Interpolation::Step,
            "CUBICSPLINE" => Interpolation::Cubic,
            other => {
                let problem = format!("there is no interpolation {:?}", other.chars().take(40).collect::<String>());
                return Err(sampler.error(problem, "write LINEAR, STEP or CUBICSPLINE"));
            }
        };
        let times: Vec<f64> = (0..input.count()).map(|index| input.vector::<1>(index)[0]).collect();
        let per_key = if interpolation == Interpolation::Cubic { 3 } else { 1 };
        if values.count() != per_key * times.len() {
            let problem = format!("{} values do not fit {} times", values.count(), times.len());
            return Err(sampler.error(problem, "export the scene again"));
        }
        if !times.is_sorted_by(|a, b| a < b) || times.iter().any(|time| !time.is_finite()) {
            return Err(sampler.error("the times do not rise", "export the scene again"));
        }
        Ok(Self { times, values, interpolation })
    }

    /// Sets `value` to that at `moment`, and tells from when to when the track lasts. Before and after it the value stays. `linear` is what
    /// goes from one value to another.
    fn sample<const N: usize>(
        &self,
        moment: f64,
        value: &mut Option<[f64; N]>,
        linear: impl Fn([f64; N], [f64; N], f64) -> [f64; N],
    ) -> [f64; 2] {
        let last = self.times.len() - 1;
        let next = self.times.partition_point(|time| *time <= moment);
        let before = next.saturating_sub(1);
        let share = match self.times.get(next).filter(|_| next > 0) {
            Some(after) => (moment - self.times[before]) / (after - self.times[before]),
            None => 0.0,
        };
        *value = Some(match self.interpolation {
            Interpolation::Linear if share > 0.0 => linear(self.values.vector(before), self.values.vector(next), share),
            Interpolation::Linear | Interpolation::Step => self.values.vector(before),
            Interpolation::Cubic if share > 0.0 => self.cubic(before, share),
            Interpolation::Cubic => self.values.vector(3 * before + 1),
        });
        [self.times[0], self.times[last]]
    }

    /// Hermite's cubic between key frame `before` and the next: each has a tangent before it, its value, and a tangent after it, by the second.
    fn cubic<const N: usize>(&self, before: usize, share: f64) -> [f64; N] {
        let seconds = self.times[before + 1] - self.times[before];
        let [start, leaving, arriving, end] = [3 * before + 1, 3 * before + 2, 3 * before + 3, 3 * before + 4]
            .map(|index| self.values.vector::<N>(index));
        let (square, cube) = (share * share, share * share * share);
        let weights = [
            2.0 * cube - 3.0 * square + 1.0,
            seconds * (cube - 2.0 * square + share),
            seconds * (cube - square),
            3.0 * square - 2.0 * cube,
        ];
        std::array::from_fn(|axis| {
            weights[0] * start[axis] + weights[1] * leaving[axis] + weights[2] * arriving[axis] + weights[3] * end[axis]
        })
    }
}
