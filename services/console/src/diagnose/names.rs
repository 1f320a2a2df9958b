//! Names for people: titles of the catalogue, sites and units in words, in place of identifiers.

use catalogue::CATALOGUE;

/// First words of titles that keep their capital within a sentence.
const PEOPLE: [&str; 5] = ["Coulomb", "Bouc-Wen", "LuGre", "Magnus", "Stribeck"];
/// Kinds of site, as they stand before the colon.
const SITES: [&str; 7] = ["joint", "body", "tank", "mode", "actuator", "sensor", "appendage"];

/// `Coulomb friction in joint pivot`: the title with its site in the place of `a joint`, else
/// behind it.
pub fn titled(title: &str, site: &str) -> String {
    let title = spaced(title);
    let kind = site.split_once(':').map_or("", |(kind, _)| kind);
    let words = site_in_words(site);
    for article in [" a ", " an "] {
        let general = format!("{article}{kind}");
        let ends = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric());
        if let Some((before, after)) = title.split_once(&general).filter(|(_, rest)| !kind.is_empty() && ends(rest)) {
            return format!("{before} {words}{after}");
        }
    }
    format!("{title} at {words}")
}

/// [`titled`] of the entry `kind` of the catalogue.
pub fn named(kind: &str, site: &str) -> String {
    // no entry of the catalogue: its site is a parameter of the plant file
    if kind == "parameter_conflict" {
        return format!("Value of {site} other than stated");
    }
    titled(&title(kind), site)
}

/// Title of the entry `kind`; the kind in words where the catalogue has no such entry.
pub fn title(kind: &str) -> String {
    CATALOGUE.effect(kind).map_or_else(|| spaced(kind), |effect| effect.title.to_owned())
}

/// `joint:pivot` as `joint pivot`.
pub fn site_in_words(site: &str) -> String {
    site.replacen(':', " ", 1)
}

/// `N*m/rad^2` as `N m/rad²`, behind a space; empty for a pure number.
pub fn unit(unit: &str) -> String {
    if matches!(unit, "" | "-" | "1") {
        return String::new();
    }
    let raised = [("^2", "²"), ("^3", "³"), ("^4", "⁴")];
    let words = of_effort(unit).unwrap_or_else(|| unit.to_owned()).replace('*', " ");
    format!(" {}", raised.iter().fold(words, |all, (from, to)| all.replace(from, to)))
}

/// An energy over a power of a coordinate as what engineers call it, the force or the torque over
/// one power less: `J s^2/rad^3` as `N*m s^2/rad^2`, `J/m^4` as `N/m^3`.
fn of_effort(unit: &str) -> Option<String> {
    let (above, below) = unit.strip_prefix('J')?.rsplit_once('/')?;
    let (of, power) = below.split_once('^').unwrap_or((below, "1"));
    let effort = match of {
        "rad" => "N*m",
        "m" => "N",
        _ => return None,
    };
    let over = match power.parse::<u32>().ok()? {
        0 => return None,
        1 => String::new(),
        2 => format!("/{of}"),
        power => format!("/{of}^{}", power - 1),
    };
    Some(format!("{effort}{above}{over}"))
}

/// A sentence with titles and sites in words in place of `kind at kind:name`, `kind@kind:name`,
/// `kind` and `kind:name`.
pub fn in_titles(text: &str) -> String {
    let words: Vec<&str> = text.split(' ').collect();
    let mut out: Vec<String> = Vec::new();
    let mut k = 0;
    while k < words.len() {
        let (open, core, close) = bare(words[k]);
        let begins = k == 0 || words[k - 1].ends_with(['.', ':']);
        let (kind, at) = core.split_once('@').map_or((core, None), |(kind, site)| (kind, Some(site)));
        let next = words.get(k + 2).filter(|_| close.is_empty() && words[k + 1] == "at").map(|word| bare(word));
        let written = match (is_effect(kind), at, next) {
            (true, Some(site), _) => Some(named(kind, site) + close),
            (true, None, Some((_, site, close))) if is_site(site) => {
                k += 2;
                Some(named(kind, site) + close)
            }
            (true, ..) if CATALOGUE.effect(kind).is_some() => Some(title(kind) + close),
            _ if is_site(core) => Some(site_in_words(core) + close),
            _ => None,
        };
        out.push(written.map_or_else(
            || words[k].to_owned(),
            |written| format!("{open}{}", if begins || is_site(core) { written } else { within(&written) }),
        ));
        k += 1;
    }
    out.join(" ")
}

/// A title within a sentence: without its capital, unless that is a person's.
pub fn within(title: &str) -> String {
    let first = title.split(' ').next().unwrap_or_default();
    if PEOPLE.contains(&first) {
        return title.to_owned();
    }
    let mut letters = title.chars();
    letters.next().map(|c| c.to_lowercase().to_string()).unwrap_or_default() + letters.as_str()
}

fn is_effect(word: &str) -> bool {
    CATALOGUE.effect(word).is_some() || (word.contains('_') && word.chars().all(|c| c.is_ascii_lowercase() || c == '_'))
}

fn is_site(word: &str) -> bool {
    word.split_once(':').is_some_and(|(kind, name)| SITES.contains(&kind) && !name.is_empty())
}

/// A word without the brackets and marks around it.
fn bare(word: &str) -> (&str, &str, &str) {
    let core = word.trim_start_matches('(');
    let (open, core) = (&word[..word.len() - core.len()], core);
    let inner = core.trim_end_matches([',', ';', ':', '.', ')']);
    (open, inner, &core[inner.len()..])
}

/// Words for underscores, with a capital letter.
pub fn spaced(kind: &str) -> String {
    let mut letters = kind.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    (first + letters.as_str()).replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_takes_its_site_in_where_it_speaks_of_one_and_else_behind_it() {
        assert_eq!(named("joint_coulomb", "joint:pivot"), "Coulomb friction in joint pivot");
        assert_eq!(named("sensor_bias", "sensor:angle"), "Bias of sensor angle");
        assert_eq!(
            titled("Harness between a free body and ground", "body:bus"),
            "Harness between a free body and ground at body bus"
        );
        assert_eq!(titled("frequency_scale", "appendage:beam"), "Frequency scale at appendage beam");
        assert_eq!(unit("N*m/rad^2"), " N m/rad²");
        assert_eq!(["J s^2/rad^3", "J/m^4", "J/rad^2", "J"].map(unit), [" N m s²/rad²", " N/m³", " N m/rad", " J"]);
        assert_eq!(unit("-"), "");
    }

    #[test]
    fn every_entry_of_the_catalogue_has_a_title_that_leaves_no_identifier_in_a_sentence() {
        for effect in CATALOGUE.entries() {
            let text = format!("held-out data reject {0} at joint:pivot, beside {0}@body:bus; {0} is", effect.kind);
            let said = in_titles(&text);
            assert!(!said.contains('_') && !said.contains('@') && !said.contains("joint:"), "{said}");
        }
    }

    #[test]
    fn within_a_sentence_only_people_keep_their_capital() {
        assert_eq!(
            in_titles("held-out data reject sensor_bias at sensor:angle, too"),
            "held-out data reject bias of sensor angle, too"
        );
        assert_eq!(in_titles("joint_coulomb at joint:pivot (p = 0.1)"), "Coulomb friction in joint pivot (p = 0.1)");
        assert_eq!(in_titles("12:30 fits run.csv: at 3 s"), "12:30 fits run.csv: at 3 s");
    }
}
