//! What is known of an uploaded scene.

use std::sync::atomic::AtomicI64;

use serde::{Deserialize, Serialize};

use crate::farm::access::user::UserName;
use crate::method::SceneTraits;
use crate::scene::Integrator;
use crate::scene::camera::CameraMatrices;
use crate::scene::light::Whereabouts;

/// A scene that was uploaded, checked and prepared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct SceneSummary {
    /// BLAKE3 of its bytes, 64 hexadecimal digits.
    pub hash: String,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Bytes of the file or archive.
    pub bytes: u64,
    /// Who uploaded it first, where there are users.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub owner: Option<UserName>,
    /// The method that its integrator asks for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub integrator: Option<String>,
    /// The light groups of its lights; empty where no light names one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub light_groups: Vec<String>,
    /// Things the user should know, one sentence each.
    pub notices: Vec<String>,
}

/// Where the camera and the lights of a scene stand, and which part of the film is the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLayout {
    /// Column and row of the film at which the picture begins.
    pub first_pixel: [u32; 2],
    /// The camera, where it stands somewhere.
    pub camera: Option<CameraMatrices>,
    /// The lights that have a place, those of most power first.
    pub lights: Vec<Whereabouts>,
}

/// What the coordinator knows of a scene. Its bytes are in the store.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneRecord {
    pub(super) summary: SceneSummary,
    /// Hash of the scene that it is with changes, if it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) base: Option<String>,
    pub(super) traits: SceneTraits,
    pub(super) integrator: Option<Integrator>,
    /// For the headers of its pictures. Records of earlier versions have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) camera: Option<CameraMatrices>,
    /// When somebody uploaded it last, milliseconds since 1970.
    #[serde(skip)]
    pub(super) uploaded: AtomicI64,
}
