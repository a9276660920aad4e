//! Quantities of a solution, and their units.
//!
//! Channels are linear RGB in W/m^2, each the power of a third of the visible spectrum as far as the whole is concerned: light of
//! 1 W/m^2 in all three has 1 W/m^2, and a sum of watts is the mean of the channels.
//!
//! Luminous quantities are K times the luminance of BT.709-6 ([`crate::luminance`]), with the luminous efficacy of white light
//! K = 179 lm/W, the constant of Radiance (Ward Larson and Shakespeare, "Rendering with Radiance", 1998, section 11.2).

use scene::Rgb;

use crate::luminance::luminance;

/// Which of a solution's values is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// B = E + rho H, W/m^2: what an eye sees.
    #[default]
    Radiosity,
    /// B / pi, W/(m^2 sr): what a camera sees.
    Radiance,
    /// H, W/m^2: what a light meter sees.
    Irradiance,
    /// The part of H that comes from emitters without reflection, W/m^2.
    Direct,
    /// The rest of H, W/m^2.
    Indirect,
    /// E, W/m^2.
    Emission,
    /// rho, dimensionless.
    Reflectance,
    /// An estimate of the error of the reflected radiosity, W/m^2, one value a patch.
    Error,
}

impl Quantity {
    /// How the command line calls it.
    pub fn option(self) -> &'static str {
        match self {
            Self::Radiosity => "radiosity",
            Self::Radiance => "radiance",
            Self::Irradiance => "irradiance",
            Self::Direct => "direct",
            Self::Indirect => "indirect",
            Self::Emission => "emission",
            Self::Reflectance => "reflectance",
            Self::Error => "error",
        }
    }
}

impl std::fmt::Display for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Radiosity => "radiosity",
            Self::Radiance => "radiance",
            Self::Irradiance => "irradiance",
            Self::Direct => "direct irradiance",
            Self::Indirect => "indirect irradiance",
            Self::Emission => "emission",
            Self::Reflectance => "reflectance",
            Self::Error => "error",
        })
    }
}

/// Which channels of a value are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// All, as a colour; where one number is needed, the luminance.
    #[default]
    All,
    /// The luminance, as a grey.
    Luminance,
    /// Red alone, as a grey.
    Red,
    /// Green alone, as a grey.
    Green,
    /// Blue alone, as a grey.
    Blue,
}

impl std::fmt::Display for Channel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::All => "all",
            Self::Luminance => "luminance of",
            Self::Red => "red",
            Self::Green => "green",
            Self::Blue => "blue",
        })
    }
}

/// Lumens of a watt of white light.
pub const LUMENS_PER_WATT: f32 = 179.0;

/// What is shown of a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shown {
    /// Which values.
    pub quantity: Quantity,
    /// Of which channels.
    pub channel: Channel,
    /// As the eye weighs them: in lumens for watts.
    pub is_luminous: bool,
}

impl Shown {
    /// The unit of the values, which is empty where they are dimensionless.
    pub fn unit(self) -> &'static str {
        match (self.quantity, self.is_luminous) {
            (Quantity::Reflectance, _) => "",
            (Quantity::Radiance, false) => "W/(m² sr)",
            (Quantity::Radiance, true) => "cd/m²",
            (_, false) => "W/m²",
            (Quantity::Irradiance | Quantity::Direct | Quantity::Indirect, true) => "lx",
            (Quantity::Radiosity | Quantity::Emission | Quantity::Error, true) => "lm/m²",
        }
    }

    /// The same for a terminal and for files of plain text.
    pub fn plain_unit(self) -> String {
        self.unit().replace('²', "^2")
    }

    /// Such as `red irradiance`.
    pub fn name(self) -> String {
        let quantity = self.quantity;
        match (self.channel, self.is_luminous) {
            (Channel::All, false) => quantity.to_string(),
            (Channel::All, true) => match quantity {
                Quantity::Irradiance => "illuminance".to_owned(),
                Quantity::Direct => "direct illuminance".to_owned(),
                Quantity::Indirect => "indirect illuminance".to_owned(),
                Quantity::Radiosity | Quantity::Emission => format!("luminous {quantity}"),
                Quantity::Radiance => "luminance".to_owned(),
                Quantity::Error | Quantity::Reflectance => quantity.to_string(),
            },
            (channel, _) => format!("{channel} {quantity}"),
        }
    }

    /// What W/m^2 are multiplied by.
    pub fn factor(self) -> f32 {
        let per_steradian = match self.quantity {
            Quantity::Radiance => std::f32::consts::FRAC_1_PI,
            _ => 1.0,
        };
        match (self.quantity, self.is_luminous) {
            (Quantity::Reflectance, _) | (_, false) => per_steradian,
            (_, true) => LUMENS_PER_WATT * per_steradian,
        }
    }

    /// A value as its channels are shown: one of them alone is grey.
    #[inline]
    pub fn of_channels(self, value: Rgb) -> Rgb {
        match self.channel {
            Channel::All => value,
            Channel::Red => Rgb::splat(value.x),
            Channel::Green => Rgb::splat(value.y),
            Channel::Blue => Rgb::splat(value.z),
            Channel::Luminance => Rgb::splat(luminance(value)),
        }
    }
}
