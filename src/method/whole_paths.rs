//! Chains of whole paths: how often each kind of change is proposed, and paths that a user gives as hints.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::Contradiction;
use super::bounded_numbers::bounded;
use super::chain_pass::MakeSpace;
use super::parameters::{Parameter, ParameterValue, parameter};
use crate::scene::Scene;
use crate::transport::counters::Step;
use crate::transport::metropolis::chains::Lengths;
use crate::transport::metropolis::path_space::PathSpace;
use crate::transport::metropolis::path_space::proposals::{Proposal, Shares};
use crate::transport::metropolis::path_space::user_path::{GivenPath, UserPath};
use crate::transport::metropolis::path_space::window::FilmWindow;

bounded! {
    /// How often a kind of change is proposed, in parts of all.
    pub(super) struct Parts(u32), [0 to 1000]
}

/// Changes that make any path of any other.
pub(super) const BIDIRECTIONAL: Parameter<Parts> =
    parameter("how often some vertices are replaced from both sides, in parts of all small steps", Parts(40), "40");
/// Changes of the place on the film to any other.
pub(super) const LENS_SUBPATH: Parameter<Parts> =
    parameter("how often the path goes to another place of the picture, in parts of all small steps", Parts(20), "20");
/// Changes of the place on the film.
pub(super) const LENS: Parameter<Parts> =
    parameter("how often the path goes to a place of the picture nearby, in parts of all small steps", Parts(20), "20");
/// Changes of the direction into mirrors and glass.
pub(super) const CAUSTIC: Parameter<Parts> =
    parameter("how often the segment into a caustic turns, in parts of all small steps", Parts(10), "10");
/// Changes of the direction from the first surface to the second.
pub(super) const PHOTON_MAP: Parameter<Parts> = parameter(
    "how often the segment behind the first surface that is no mirror turns, in parts of all small steps",
    Parts(10),
    "10",
);
/// Changes to paths near given ones.
pub(super) const USER_PATH: Parameter<Parts> =
    parameter("how often a path near one of user_paths is tried, in parts of all small steps", Parts(10), "10");
/// The given ones.
pub(super) const USER_PATHS: Parameter<UserPaths> = parameter(
    "hints where light comes from, each {\"points\": from a lamp to a surface that is no mirror, \"cones\": half angles around the segments, °; one for all, else 5}",
    UserPaths(Vec::new()),
    "[]",
);

/// Most paths that a user may give.
const MOST_PATHS: usize = 1000;
/// Most points of one.
const MOST_POINTS: usize = 32;
/// The half angle of cones where none is given, degrees.
const USUAL_CONE: f32 = 5.0;

/// Paths that a user gives.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<UserPathText>", into = "Vec<UserPathText>")]
pub(super) struct UserPaths(Vec<UserPathText>);

/// One of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct UserPathText {
    /// m.
    points: Vec<[f32; 3]>,
    /// Degrees.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    cones: Vec<f32>,
}

impl TryFrom<Vec<UserPathText>> for UserPaths {
    type Error = String;

    fn try_from(paths: Vec<UserPathText>) -> Result<Self, String> {
        if paths.len() > MOST_PATHS {
            return Err(format!("at most {MOST_PATHS} paths"));
        }
        for UserPathText { points, cones } in &paths {
            let counts_fit =
                (2..=MOST_POINTS).contains(&points.len()) && [0, 1, points.len() - 1].contains(&cones.len());
            let all_fit = points.iter().flatten().all(|coordinate| coordinate.is_finite());
            if !counts_fit || !all_fit || !cones.iter().all(|cone| *cone > 0.0 && *cone <= 90.0) {
                return Err("points or cones out of range".to_owned());
            }
        }
        Ok(Self(paths))
    }
}

impl From<UserPaths> for Vec<UserPathText> {
    fn from(paths: UserPaths) -> Self {
        paths.0
    }
}

impl ParameterValue for UserPaths {
    const RANGE: &'static str =
        "a list of at most 1000, of 2 to 32 points each; cones above 0 to 90, one or as many as segments";
}

impl UserPaths {
    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All of them, as they are followed in `scene`; which one it refuses, and why.
    pub(super) fn checked(&self, scene: &Scene) -> Result<Vec<UserPath>, Contradiction> {
        let check = |(index, path): (usize, &UserPathText)| {
            let segments = path.points.len() - 1;
            let degrees =
                |segment: usize| path.cones.get(segment).or(path.cones.first()).copied().unwrap_or(USUAL_CONE);
            let cones = (0..segments).map(|segment| degrees(segment).to_radians()).collect();
            UserPath::check(scene, &GivenPath { points: &path.points, cones }).map_err(|error| Contradiction {
                problem: format!("path {} of user_paths: {error}", index + 1),
                remedy: "correct it, or leave it out".to_owned(),
            })
        };
        self.0.iter().enumerate().map(check).collect()
    }
}

/// How often each kind of change is proposed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Proposals {
    pub(super) bidirectional: Parts,
    pub(super) lens_subpath: Parts,
    pub(super) lens: Parts,
    pub(super) caustic: Parts,
    pub(super) photon_map: Parts,
    pub(super) user_path: Parts,
}

impl Proposals {
    /// In parts of all, where given paths are only followed if there are some.
    pub(super) fn shares(&self, user_paths: &[UserPath]) -> Shares {
        let parts = Proposal::ALL.iter().map(|kind| match kind {
            Proposal::User if user_paths.is_empty() => 0.0,
            kind => self.parts(*kind).get() as f32,
        });
        Shares::new(std::array::from_fn(|index| parts.clone().nth(index).unwrap_or(0.0)))
    }

    fn parts(&self, kind: Proposal) -> Parts {
        match kind {
            Proposal::Bidirectional => self.bidirectional,
            Proposal::LensSubpath => self.lens_subpath,
            Proposal::Lens => self.lens,
            Proposal::Caustic => self.caustic,
            Proposal::PhotonMap => self.photon_map,
            Proposal::User => self.user_path,
        }
    }

    /// What is counted.
    pub(super) fn steps(user_paths: &UserPaths) -> &'static [Step] {
        const ALL: [Step; 7] = [
            Step::Large,
            Step::Bidirectional,
            Step::LensSubpath,
            Step::Lens,
            Step::Caustic,
            Step::PhotonMap,
            Step::User,
        ];
        if user_paths.is_empty() { &ALL[..6] } else { &ALL }
    }

    /// Whether nothing is left to propose, or given paths are never followed.
    pub(super) fn contradiction(&self, user_paths: &UserPaths) -> Option<Contradiction> {
        let is_given = !user_paths.is_empty();
        if is_given && self.user_path.get() == 0 {
            let problem = "user_paths are given, and user_path is 0".to_owned();
            return Some(Contradiction {
                problem,
                remedy: "give user_path some parts, or leave user_paths out".to_owned(),
            });
        }
        let all: u32 = Proposal::ALL.iter().map(|kind| self.parts(*kind).get()).sum();
        let left = if is_given { all } else { all - self.user_path.get() };
        (left == 0).then(|| Contradiction {
            problem: "no kind of change has any part".to_owned(),
            remedy: "give one of bidirectional, lens_subpath, lens, caustic and photon_map some parts".to_owned(),
        })
    }
}

/// Makes spaces of whole paths.
pub(super) struct WholePaths {
    pub(super) shares: Shares,
    pub(super) user_paths: Vec<UserPath>,
}

impl MakeSpace for WholePaths {
    type Space<'a> = PathSpace<'a>;

    fn space<'a>(&'a self, scene: &'a Scene, lengths: Lengths, pixels: Range<u32>) -> PathSpace<'a> {
        let Self { shares, user_paths } = self;
        PathSpace {
            scene,
            lengths,
            window: FilmWindow::new(scene),
            shares: shares.clone(),
            user_paths,
            least_importance: 0.0,
            pixels,
        }
    }
}
