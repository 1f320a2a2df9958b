//! Effects that a plant carries, checked against the catalogue.

use super::{EffectUse, Plant, Quantity, Site, nearest::suggestion};
use crate::effect::{self, Catalogue, Effect, EffectParameter, Role};

impl Plant {
    /// Adds effect `kind` at `site`; `values` in SI, absent ones have the catalogue's default.
    ///
    /// # Errors
    /// An unknown name or an impossible value, with the nearest known word.
    pub fn add_effect(&mut self, kind: &str, site: &Site, values: &[(&str, f64)]) -> Result<(), String> {
        let values = values.iter().map(|(name, value)| ((*name).to_owned(), Quantity::known(*value))).collect();
        let effect = EffectUse { kind: kind.to_owned(), site: site.clone(), values };
        let entry = self.catalogue.known(&effect.kind)?;
        check_site(self, entry, &effect.site)?;
        self.effects.push(in_catalogue_order(effect, entry)?);
        Ok(())
    }

    /// Sorts effects into the order in which they act: that of the catalogue, then of their sites.
    /// Those of another catalogue come last, as they are.
    pub fn order_of_action(&self, used: &EffectUse) -> (usize, String) {
        let place = self.catalogue.place(&used.kind);
        let known = place < self.catalogue.entries().len();
        (place, if known { used.site.to_string() } else { String::new() })
    }

    /// The plant without effects whose readings are staircases, which have no derivative.
    #[must_use]
    pub fn without_staircases(&self) -> Self {
        let mut smooth = self.clone();
        smooth.effects.retain(|used| self.catalogue.effect(&used.kind).is_none_or(|effect| !effect.staircase));
        smooth
    }

    /// The value of the parameter of an effect that has this role, and whether it is known.
    pub fn stated(&self, used: &EffectUse, role: Role) -> Option<Quantity> {
        let parameter = self.catalogue.effect(&used.kind)?.with_role(role)?;
        used.values.iter().find(|(name, _)| name == parameter.name).map(|(_, quantity)| *quantity)
    }

    /// The plant without effects of the catalogue.
    #[must_use]
    pub fn without_effects(&self) -> Self {
        Self { effects: Vec::new(), ..self.clone() }
    }
}

impl EffectUse {
    /// The same with every parameter of the catalogue's entry stated; absent ones get their
    /// default.
    #[must_use]
    pub(super) fn in_full(&self, catalogue: Catalogue) -> Self {
        let Some(entry) = catalogue.effect(&self.kind) else { return self.clone() };
        let mut effect = self.clone();
        for parameter in entry.parameters {
            if !effect.values.iter().any(|(name, _)| name == parameter.name) {
                effect.values.push((parameter.name.to_owned(), Quantity::known(parameter.default)));
            }
        }
        in_catalogue_order(effect, entry).unwrap_or_else(|_| self.clone())
    }
}

impl Catalogue {
    /// The entry called `kind`.
    ///
    /// # Errors
    /// The catalogue has no such entry; the nearest is suggested.
    pub fn known(&self, kind: &str) -> Result<&'static Effect, String> {
        self.effect(kind).ok_or_else(|| {
            let kinds = self.entries().iter().map(|effect| effect.kind);
            joined(format!("no effect is called '{kind}'"), &suggestion(kind, "effects", kinds))
        })
    }
}

/// # Errors
/// The plant has no such site, or the effect cannot sit there.
pub fn check_site(plant: &Plant, entry: &Effect, site: &Site) -> Result<(), String> {
    if !entry.sites.contains(&site.kind) {
        let kinds: Vec<&str> = entry.sites.iter().map(|kind| kind.name()).collect();
        return Err(format!("{} sits at a {}, not at '{site}'", entry.kind, kinds.join(" or a ")));
    }
    let sites = effect::sites(entry, plant);
    if sites.contains(site) {
        return Ok(());
    }
    let exists = plant.sites(site.kind).contains(site);
    let message = if exists {
        format!("{} cannot sit at '{site}'", entry.kind)
    } else {
        format!("the plant has no site '{site}'")
    };
    let known: Vec<String> = sites.iter().map(Site::to_string).collect();
    let near = suggestion(&site.to_string(), &format!("sites of {}", entry.kind), known.iter().map(String::as_str));
    Err(joined(message, &near))
}

/// Values in the catalogue's order.
///
/// # Errors
/// A name that the entry does not have, a name given twice, a value that is not finite.
pub fn in_catalogue_order(effect: EffectUse, entry: &Effect) -> Result<EffectUse, String> {
    for (i, (name, quantity)) in effect.values.iter().enumerate() {
        known_parameter(entry, name)?;
        if effect.values[..i].iter().any(|(earlier, _)| earlier == name) {
            return Err(format!("{name} of {} is given twice", entry.kind));
        }
        if !quantity.value.is_finite() {
            return Err(format!("{name} of {} = {}: not a finite number", entry.kind, quantity.value));
        }
    }
    let find = |name: &str| effect.values.iter().find(|(given, _)| given == name).cloned();
    Ok(EffectUse { values: entry.parameters.iter().filter_map(|parameter| find(parameter.name)).collect(), ..effect })
}

/// # Errors
/// The entry has no such parameter.
pub fn known_parameter<'e>(entry: &'e Effect, name: &str) -> Result<&'e EffectParameter, String> {
    entry.parameters.iter().find(|parameter| parameter.name == name).ok_or_else(|| {
        let known = entry.parameters.iter().map(|parameter| parameter.name);
        joined(format!("{} has no parameter '{name}'", entry.kind), &suggestion(name, "parameters", known))
    })
}

/// Values outside their plausible range: name, message, and the meaning of the parameter.
pub fn implausible<'u>(
    plant: &Plant,
    entry: &'static Effect,
    effect: &'u EffectUse,
) -> Vec<(&'u str, String, &'static str)> {
    let mut list = Vec::new();
    for (name, quantity) in &effect.values {
        let Ok(parameter) = known_parameter(entry, name) else { continue };
        let (value, low, high) = (quantity.value, parameter.low, parameter.high);
        if value < low || value > high {
            let unit = unit_at(plant, &effect.site, parameter.unit);
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            let of = format!("effect '{}'", entry.kind);
            let message = format!("{name} = {value}{unit} of {of} is outside its plausible range {low} … {high}{unit}");
            list.push((name.as_str(), message, parameter.what));
        }
    }
    list
}

fn joined(message: String, cure: &str) -> String {
    if cure.is_empty() { message } else { format!("{message}; {cure}") }
}

/// Unit of each value that is given.
pub(super) fn units(plant: &Plant, effect: &EffectUse) -> Vec<String> {
    let entry = plant.catalogue.effect(&effect.kind);
    let parameter = |name: &str| entry.and_then(|entry| entry.parameters.iter().find(|p| p.name == name));
    let unit = |name: &str| parameter(name).map_or_else(|| "1".to_owned(), |p| unit_at(plant, &effect.site, p.unit));
    effect.values.iter().map(|(name, _)| unit(name)).collect()
}

/// The catalogue's unit with the site's in the place of each `*`.
pub fn unit_at(plant: &Plant, site: &Site, unit: &str) -> String {
    let of_site = plant.site_unit(site);
    // as people write them
    match (unit, of_site) {
        ("J/*", "rad") => return "N*m".into(),
        ("J/*", "m") => return "N".into(),
        ("J s/*^2", "rad") => return "N*m*s/rad".into(),
        ("J s/*^2", "m") => return "N*s/m".into(),
        ("J/*^2", "rad") => return "N*m/rad".into(),
        ("J/*^2", "m") => return "N/m".into(),
        _ => {}
    }
    let plain = of_site.chars().all(char::is_alphanumeric);
    unit.replace('*', &if plain || unit == "*" { of_site.to_owned() } else { format!("({of_site})") })
}
