use super::*;
use dynamics::effect::sites;

#[test]
fn every_entry_of_a_menu_is_an_entry_of_the_catalogue_at_a_site_of_the_plant() {
    for bench in BENCHES {
        let plant = kept(bench);
        assert!(plant_file::validate::validate(&plant).is_empty(), "{}", bench.plant);
        for entry in bench.menu {
            let known = plant.catalogue.effect(entry.kind).unwrap_or_else(|| panic!("{}", entry.kind));
            let here: Vec<String> = sites(known, &plant).iter().map(ToString::to_string).collect();
            assert!(here.contains(&entry.site.to_owned()), "{} {} {here:?}", entry.kind, entry.site);
            assert_eq!(known.parameters[0].name, entry.amplitude.0, "{}", entry.kind);
            for (name, ..) in entry.shape {
                assert!(known.parameters.iter().any(|p| p.name == *name), "{} {name}", entry.kind);
            }
            for kin in entry.kin {
                assert!(plant.catalogue.effect(kin).is_some(), "{kin}");
            }
        }
    }
}
