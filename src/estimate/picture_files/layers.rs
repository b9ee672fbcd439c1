//! The further layers that an EXR picture may hold: one row each in [`LAYERS`], which the API, the command line, the
//! EXR writer and the documents all read.

/// A further layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// Gather radius.
    Radius,
    /// Photons accumulated.
    Photons,
    /// Standard error of the picture by noise.
    Error,
    /// The share of light that the first surface seen scatters.
    Albedo,
    /// Its shading normal.
    Normal,
    /// Its distance.
    Depth,
    /// Its place.
    Position,
    /// The picture with less noise.
    Denoised,
    /// Standard error of that.
    DenoisedError,
    /// The light of each light group; of jobs that keep them apart.
    LightGroups,
    /// Which objects cover how much of a pixel.
    CryptoObject,
    /// Which materials do.
    CryptoMaterial,
}

/// What a layer is called and holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LayerRow {
    /// The layer.
    pub layer: Layer,
    /// What users call it.
    pub name: &'static str,
    /// Its channels in a file.
    pub channels: &'static [&'static str],
    /// What they hold.
    pub meaning: &'static str,
    /// Its unit; empty where there is none.
    pub unit: &'static str,
    /// What they hold where there is nothing to tell; empty where that cannot be.
    pub nothing: &'static str,
    /// Whether 16 bits are enough for it in a picture of half precision; else it stays at 32.
    pub allows_half: bool,
}

impl LayerRow {
    /// The row of the layer that is called `name` or has a channel of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        if name.starts_with(OF_LIGHT_GROUP) {
            return Some(Layer::LightGroups.row());
        }
        LAYERS.iter().find(|row| row.name == name || row.channels.contains(&name))
    }

    /// All of it in words.
    pub fn description(&self) -> String {
        let Self { meaning, unit, nothing, .. } = self;
        let part =
            |separator: &str, text: &str| if text.is_empty() { String::new() } else { format!("{separator}{text}") };
        format!("{meaning}{}{}", part(", ", unit), part("; ", nothing))
    }
}

/// The unit of a picture's colors, in letters that every font has.
pub(super) const RADIANCE_UNIT: &str = "W/(sr·m²)";

/// The depth of pixels in which nothing is seen, m. It is behind everything and yet finite: infinity times a weight of 0
/// would spread NaN when a picture is blurred or scaled.
pub const NOTHING_SEEN: f32 = 1e10;

/// How the names of channels of light groups begin, before the group's name.
pub const OF_LIGHT_GROUP: &str = "light_group.";
/// What stands for the group's name in the table.
const GROUP_NAME: &str = "NAME";

/// The channels of a matte in the order of their ranks: three times two pairs of id and coverage.
macro_rules! matte_channels {
    ($name:literal) => {
        [
            concat!($name, "00.R"),
            concat!($name, "00.G"),
            concat!($name, "00.B"),
            concat!($name, "00.A"),
            concat!($name, "01.R"),
            concat!($name, "01.G"),
            concat!($name, "01.B"),
            concat!($name, "01.A"),
            concat!($name, "02.R"),
            concat!($name, "02.G"),
            concat!($name, "02.B"),
            concat!($name, "02.A"),
        ]
    };
}

/// All layers, in the order of [`Layer`].
pub const LAYERS: [LayerRow; 12] = [
    LayerRow {
        layer: Layer::Radius,
        name: "radius",
        channels: &["radius.Y"],
        meaning: "gather radius",
        unit: "m",
        nothing: "",
        allows_half: false,
    },
    LayerRow {
        layer: Layer::Photons,
        name: "photons",
        channels: &["photons.Y"],
        meaning: "photons accumulated",
        unit: "",
        nothing: "",
        allows_half: false,
    },
    LayerRow {
        layer: Layer::Error,
        name: "error",
        channels: &["error.Y"],
        meaning: "standard error by noise, as the job itself estimates",
        unit: RADIANCE_UNIT,
        nothing: "NaN before each twin has a pass",
        allows_half: false,
    },
    LayerRow {
        layer: Layer::Albedo,
        name: "albedo",
        channels: &["albedo.R", "albedo.G", "albedo.B"],
        meaning: "share of light that the first surface seen reflects or transmits",
        unit: "",
        nothing: "",
        allows_half: true,
    },
    LayerRow {
        layer: Layer::Normal,
        name: "normal",
        channels: &["normal.X", "normal.Y", "normal.Z"],
        meaning: "shading normal of the first surface seen, world space",
        unit: "",
        nothing: "",
        allows_half: true,
    },
    LayerRow {
        layer: Layer::Depth,
        name: "depth",
        channels: &["depth.Z"],
        meaning: "distance of the first surface seen from the camera",
        unit: "m",
        nothing: "1e10 where nothing is seen",
        allows_half: false,
    },
    LayerRow {
        layer: Layer::Position,
        name: "position",
        channels: &["position.X", "position.Y", "position.Z"],
        meaning: "place of the first surface seen, world space",
        unit: "m",
        nothing: "0 where nothing is seen",
        allows_half: false,
    },
    LayerRow {
        layer: Layer::Denoised,
        name: "denoised",
        channels: &["denoised.R", "denoised.G", "denoised.B"],
        meaning: "the picture with less noise, filtered by what its two halves and its first surfaces tell",
        unit: RADIANCE_UNIT,
        nothing: "",
        allows_half: true,
    },
    LayerRow {
        layer: Layer::DenoisedError,
        name: "denoised_error",
        channels: &["denoised_error.Y"],
        meaning: "standard error of the picture with less noise, as its two halves tell",
        unit: RADIANCE_UNIT,
        nothing: "",
        allows_half: false,
    },
    LayerRow {
        layer: Layer::LightGroups,
        name: "light_groups",
        channels: &["light_group.NAME.R", "light_group.NAME.G", "light_group.NAME.B"],
        meaning: "light of each light group, of jobs that keep them apart; their sum is the picture",
        unit: RADIANCE_UNIT,
        nothing: "",
        allows_half: true,
    },
    LayerRow {
        layer: Layer::CryptoObject,
        name: "crypto_object",
        channels: &matte_channels!("CryptoObject"),
        meaning: "six pairs of id and coverage of the objects seen first, as Cryptomatte has them",
        unit: "",
        nothing: "0 where there are fewer",
        allows_half: false,
    },
    LayerRow {
        layer: Layer::CryptoMaterial,
        name: "crypto_material",
        channels: &matte_channels!("CryptoMaterial"),
        meaning: "the same of materials",
        unit: "",
        nothing: "0 where there are fewer",
        allows_half: false,
    },
];

/// A layer of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureLayer {
    /// Which one.
    pub layer: Layer,
    /// The values of each of its channels: row-major, top row first, as many as the picture has pixels.
    pub channels: Vec<Vec<f32>>,
    /// Of [`Layer::LightGroups`] the groups, whose channels follow one after the other; else empty.
    pub light_groups: Vec<String>,
}

impl PictureLayer {
    /// A layer that has the channels of its row.
    pub fn new(layer: Layer, channels: Vec<Vec<f32>>) -> Self {
        Self { layer, channels, light_groups: Vec::new() }
    }

    /// The names of its channels in a file.
    pub fn channel_names(&self) -> Vec<String> {
        let of_row = self.layer.row().channels.iter();
        match self.layer {
            Layer::LightGroups => {
                let of_group = |group: &String| of_row.clone().map(|name| name.replace(GROUP_NAME, group)).collect();
                self.light_groups.iter().flat_map(|group| -> Vec<String> { of_group(group) }).collect()
            }
            _ => of_row.map(|name| (*name).to_owned()).collect(),
        }
    }
}

/// A name that no layer has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no layer \"{0}\"")]
pub struct UnknownLayer(pub String);

impl Layer {
    /// Whether it is made of the denoised picture.
    pub fn is_denoised(self) -> bool {
        matches!(self, Self::Denoised | Self::DenoisedError)
    }

    /// Whether a worker has to look at first surfaces for it.
    pub fn needs_first_surfaces(self) -> bool {
        self.is_denoised() || matches!(self, Self::Albedo | Self::Normal | Self::Depth | Self::Position)
    }

    /// Whether it holds ids, which cannot be averaged or shown as colors.
    pub fn is_matte(self) -> bool {
        matches!(self, Self::CryptoObject | Self::CryptoMaterial)
    }

    /// Its row of the table.
    pub fn row(self) -> &'static LayerRow {
        &LAYERS[self as usize]
    }

    /// The layers that a list names, separated by commas; each once, in the order of the table.
    pub fn parse_list(list: &str) -> Result<Vec<Self>, UnknownLayer> {
        let names = list.split(',').map(str::trim).filter(|name| !name.is_empty());
        let layer = |name: &str| {
            let row = LAYERS.iter().find(|row| row.name == name);
            row.map(|row| row.layer).ok_or_else(|| UnknownLayer(name.to_owned()))
        };
        let mut layers = names.map(layer).collect::<Result<Vec<_>, _>>()?;
        layers.sort_unstable();
        layers.dedup();
        Ok(layers)
    }

    /// The names of the layers that can be looked at, separated by commas.
    pub fn known_to_look_at() -> String {
        let shown = LAYERS.iter().filter(|row| !row.layer.is_matte()).map(|row| row.name);
        shown.collect::<Vec<_>>().join(", ")
    }

    /// The names of all layers, separated by commas.
    pub fn known() -> String {
        LAYERS.map(|row| row.name).join(", ")
    }
}
