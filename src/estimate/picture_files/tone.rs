//! Tone curves: which code value, 0 (black) to 1 (white), a screen gets for a linear Rec. 709 color that may be brighter than any screen.
//! One row each in [`TONES`].

/// A tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Colors as they are; brighter than 1 is white.
    #[default]
    Linear,
    /// Film's soft highlights, each channel alone.
    Filmic,
    /// Film's soft highlights, which lose their color as they grow brighter.
    Agx,
}

/// What a tone curve is called and does.
#[derive(Clone, Copy, Debug)]
pub struct ToneRow {
    /// The curve.
    pub tone: ToneCurve,
    /// What users call it.
    pub name: &'static str,
    /// What it does, and where it is published.
    pub meaning: &'static str,
}

/// All tone curves, in the order of [`ToneCurve`].
pub const TONES: [ToneRow; 3] = [
    ToneRow { tone: ToneCurve::Linear, name: "linear", meaning: "colors as they are; brighter than 1 is white" },
    ToneRow {
        tone: ToneCurve::Filmic,
        name: "filmic",
        meaning: "soft shadows and highlights, each channel alone [Hable 2010]; 5.6 is white",
    },
    ToneRow {
        tone: ToneCurve::Agx,
        name: "agx",
        meaning: "soft highlights that lose their color as they grow brighter [Sobotka 2022]; 16.3 is white",
    },
];

impl ToneCurve {
    /// Its row of the table.
    pub fn row(self) -> &'static ToneRow {
        &TONES[self as usize]
    }

    /// The code values of a linear Rec. 709 color. Those outside of 0 to 1 are meant as the nearest of both, and what is no number as black.
    pub fn code_values(self, color: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Linear => color.map(srgb),
            Self::Filmic => color.map(|channel| srgb(filmic(channel))),
            Self::Agx => agx(color),
        }
    }
}

/// The sRGB transfer function (IEC 61966-2-1).
fn srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055 }
}

/// The sRGB transfer function and rounding. Negative and not-a-number give 0.
pub(crate) fn srgb_byte(linear: f32) -> u8 {
    byte(srgb(linear))
}

/// A code value in 8 bits. Negative and not-a-number give 0.
pub(super) fn byte(code_value: f32) -> u8 {
    (code_value * 255.0).round() as u8
}

/// John Hable's curve of Uncharted 2 [Hable 2010]: f(2 x) / f(11.2), where f is a ratio of quadratic polynomials with the constants
/// that he gives for shoulder, linear part and toe. It is white at 11.2 / 2 = 5.6.
fn filmic(linear: f32) -> f32 {
    const EXPOSURE_BIAS: f32 = 2.0;
    const WHITE: f32 = 11.2;
    const SHOULDER_STRENGTH: f32 = 0.15;
    const LINEAR_STRENGTH: f32 = 0.5;
    const LINEAR_ANGLE: f32 = 0.1;
    const TOE_STRENGTH: f32 = 0.2;
    const TOE_NUMERATOR: f32 = 0.02;
    const TOE_DENOMINATOR: f32 = 0.3;
    let curve = |x: f32| {
        let numerator = x * (SHOULDER_STRENGTH * x + LINEAR_ANGLE * LINEAR_STRENGTH) + TOE_STRENGTH * TOE_NUMERATOR;
        let denominator = x * (SHOULDER_STRENGTH * x + LINEAR_STRENGTH) + TOE_STRENGTH * TOE_DENOMINATOR;
        numerator / denominator - TOE_NUMERATOR / TOE_DENOMINATOR
    };
    curve((EXPOSURE_BIAS * linear).clamp(0.0, WHITE)) / curve(WHITE)
}

/// Rec. 709 to primaries that lie further inwards, so that bright colors of one channel reach the others, too [Sobotka 2022]; by rows.
const AGX_INSET: [[f32; 3]; 3] = [
    [0.842_479_05, 0.078_433_6, 0.079_223_745],
    [0.042_328_242, 0.878_468_63, 0.079_166_13],
    [0.042_375_654, 0.078_433_6, 0.879_143],
];
const AGX_MIDDLE_GREY: f32 = 0.18;
/// Stops below and above middle grey that differ from black and white.
const AGX_STOPS: [f32; 2] = [-10.0, 6.5];

/// Troy Sobotka's AgX, its base image without a look [Sobotka 2022]: negative light is black, the inset matrix, log2 of what is left
/// over ten stops below to six and a half above middle grey, and a sigmoid. The result is meant for a display with a power of 2.2, as sRGB
/// screens are, and is not encoded again.
fn agx(color: [f32; 3]) -> [f32; 3] {
    let light = color.map(|channel| channel.max(0.0));
    let [darkest, brightest] = AGX_STOPS;
    AGX_INSET.map(|row| {
        let inset = row[0] * light[0] + row[1] * light[1] + row[2] * light[2];
        // The logarithm of 0 is minus infinity, which is black.
        let stops = libm::log2f(inset / AGX_MIDDLE_GREY).clamp(darkest, brightest);
        agx_sigmoid((stops - darkest) / (brightest - darkest))
    })
}

/// Jed Smith's sigmoid as AgX sets it: middle grey goes to 0.5 with a slope of 2, and from there a hyperbola of power 3 down to (0, 0) and one
/// of power 3.25 up to (1, 1).
fn agx_sigmoid(x: f32) -> f32 {
    const SLOPE: f32 = 2.0;
    const MIDDLE: f32 = 0.5;
    // A line of that slope reaches `rise` where the curve is to reach 0.5: the scale is rise ((rise / 0.5)^power − 1)^(−1 / power).
    const TOE: [f32; 2] = [3.0, -0.512_277_4];
    const SHOULDER: [f32; 2] = [3.25, 0.541_464_15];
    let [darkest, brightest] = AGX_STOPS;
    let pivot = -darkest / (brightest - darkest);
    let [power, scale] = if x < pivot { TOE } else { SHOULDER };
    let along = SLOPE * (x - pivot) / scale;
    MIDDLE + scale * along / libm::powf(1.0 + libm::powf(along, power), 1.0 / power)
}
