//! One of each idea: a numerical method that has a name is written once.

use crate::house::House;
use crate::source::Source;
use std::collections::BTreeMap;
use syn::visit::{self, Visit};

/// Words in the names of functions and modules that give a method away (of the gate: in the names
/// of constants), and the one file that may have such a name.
const IDEAS: [(&str, &[&str], &str); 6] = [
    ("the exponential of a matrix", &["expm", "exponential"], "shared/estimation/src/matrix_exponential.rs"),
    (
        "Levenberg–Marquardt",
        &["levenberg", "marquardt", "damped_step", "gauss_newton"],
        "shared/estimation/src/levenberg_marquardt.rs",
    ),
    ("golden section", &["golden_section"], "shared/estimation/src/golden_section.rs"),
    ("Runge–Kutta", &["runge", "rk4"], "shared/dynamics/src/system/runge_kutta.rs"),
    ("quantiles of a sample", &["median", "quantile", "percentile"], "shared/estimation/src/quantiles.rs"),
    (GATE, &["gate_sigma"], "shared/estimation/src/lib.rs"),
];
const GATE: &str = "the gate of an innovation";

/// What has such a name and is another idea, with the reason.
const OTHERS: [(&str, &str, &str); 10] = [
    ("shared/challenge/", "median", "published scores: half the sum of the two in the middle, to the last bit"),
    ("shared/dynamics/src/multibody/", "exponential_series", "of a rotation vector: the map onto the group"),
    ("shared/estimation/src/consistency/laws.rs", "quantile", "of a law, not of a sample"),
    ("shared/examination/", "quantile_departure", "calls the one"),
    (
        "shared/identification/src/statistics.rs",
        "chi_squared_quantile",
        "of a law, exact; the one that flies is bounded",
    ),
    ("shared/bench/", "medians", "calls the one"),
    ("shared/recording/", "median", "an order statistic: an interval that the record has"),
    ("shared/runtime/", "percentile_us", "of a histogram, which keeps no samples"),
    ("services/inertial-id/", "median", "an order statistic: an interval that was measured"),
    ("services/console/src/plant/", "median_step", "an order statistic: a step that the file has"),
];

/// `path:line name: idea, which is in file`, of every definition elsewhere.
pub fn measure(house: &House) -> Vec<String> {
    let mut found = Vec::new();
    for (_, source) in house.own_sources() {
        let mut scan = Scan { source, names: BTreeMap::new() };
        scan.visit_file(&source.syntax);
        for (line, (name, is_constant)) in scan.names {
            let lower = name.to_lowercase();
            let is_other = |(place, own, _): &(&str, &str, &str)| source.path.starts_with(place) && lower.contains(own);
            for (idea, words, home) in IDEAS.into_iter().filter(|(idea, ..)| (*idea == GATE) == is_constant) {
                let is_it = words.iter().any(|word| lower.contains(word)) && !declares(&source.path, &lower, home);
                if is_it && source.path != home && !OTHERS.iter().any(is_other) {
                    found.push(format!("{}:{line} {name}: {idea}, which is in {home}", source.path));
                }
            }
        }
    }
    found
}

/// `mod name;` in the file above the one that has the idea.
fn declares(path: &str, name: &str, home: &str) -> bool {
    let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
    let below = path.strip_suffix(".rs").unwrap_or(path);
    [folder, below].iter().any(|folder| home == format!("{folder}/{name}.rs"))
}

/// Names of functions and modules, and of constants (true), outside tests.
struct Scan<'a> {
    source: &'a Source,
    names: BTreeMap<usize, (String, bool)>,
}

impl Scan<'_> {
    fn keep(&mut self, name: &syn::Ident, is_constant: bool) {
        let line = name.span().start().line;
        if !self.source.is_test_at(line) {
            self.names.insert(line, (name.to_string(), is_constant));
        }
    }
}

impl<'a> Visit<'a> for Scan<'_> {
    fn visit_signature(&mut self, signature: &'a syn::Signature) {
        self.keep(&signature.ident, false);
        visit::visit_signature(self, signature);
    }

    fn visit_item_mod(&mut self, item: &'a syn::ItemMod) {
        self.keep(&item.ident, false);
        visit::visit_item_mod(self, item);
    }

    fn visit_item_const(&mut self, item: &'a syn::ItemConst) {
        self.keep(&item.ident, true);
        visit::visit_item_const(self, item);
    }
}

#[test]
fn a_method_with_a_name_is_written_once() {
    let found = &crate::findings().twice;
    assert!(
        found.is_empty(),
        "{}\nCure: call the one there is. Another idea takes another name, or a line in OTHERS with its reason.",
        found.join("\n")
    );
}

#[test]
fn a_second_method_is_seen_and_a_call_or_a_test_of_the_one_is_not() {
    let text = "pub fn matrix_exponential() {}\nfn calls() { golden_section() }\n\
                #[cfg(test)]\nmod tests {\n    fn median() {}\n}\n\
                const GATE_SIGMA: f64 = 5.0;\nmod levenberg {}\n";
    let found = measure(&House::trial(&[("src/lib.rs", text)]));
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(found[0].starts_with("shared/trial/src/lib.rs:1 matrix_exponential: the exponential"), "{found:?}");
    assert!(found[1].contains(":7 GATE_SIGMA") && found[2].contains(":8 levenberg"), "{found:?}");
}
