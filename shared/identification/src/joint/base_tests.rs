//! Base values of a planar craft against numbers of other equations (recordings/study_case, craft
//! t1; CC0).

use crate::synthetic::plant;
use dynamics::description::{Joint, JointKind, Plant, Quantity};

/// As `obsid plant parameters` lists them.
const PHYSICAL: [(&str, f64); 37] = [
    ("hub.mass", 976.1282527501812),
    ("hub.com.x", -0.016983491265376176),
    ("hub.com.y", 0.01372147264939956),
    ("hub.inertia.zz", 515.1688859220861),
    ("link_1.mass", 12.14444588612641),
    ("link_1.com.x", 1.0285519714573883),
    ("link_1.com.y", 0.005303989200329069),
    ("link_1.inertia.zz", 4.555680584577337),
    ("shoulder.friction", 0.19257775529847876),
    ("shoulder.rotor_inertia", 0.7867163274892536),
    ("link_2.mass", 11.780466678455136),
    ("link_2.com.x", 0.9256821627312383),
    ("link_2.com.y", 0.004820083658367808),
    ("link_2.inertia.zz", 3.3032766931785233),
    ("elbow.friction", 0.2900695001698692),
    ("elbow.rotor_inertia", 0.4890676539766472),
    ("fuel.position.x", -0.4461356376869924),
    ("fuel.position.y", 0.19994668567073656),
    ("fuel.mass", 35.7750741049111),
    ("fuel.stiffness.x", 0.14911592519599634),
    ("fuel.stiffness.y", 0.12135669311170122),
    ("fuel.damping.x", 0.02863419422240346),
    ("fuel.damping.y", 0.042808864747514816),
    ("bending_1.frequency", 0.9295388870796194),
    ("bending_1.damping_ratio", 0.006503047227366278),
    ("bending_1.translation.x", 2.6646426059289983),
    ("bending_1.rotation.z", 11.347687764585427),
    ("bending_1.shape.middle.x", 0.2031967316083086),
    ("bending_1.shape.tip.x", 0.6413196286659307),
    ("bending_2.frequency", 6.422276695706688),
    ("bending_2.damping_ratio", 0.013365064822869008),
    ("bending_2.translation.x", 1.2574944436387514),
    ("bending_2.rotation.z", 2.348422721969768),
    ("bending_2.shape.middle.x", 0.4332476003986472),
    ("bending_2.shape.tip.x", -0.5906186099099869),
    ("wheel.inertia", 0.08019508420859367),
    ("wheel.friction", 0.00011823836978502822),
];

/// Base parameters of these.
const BASE: [(&str, f64); 35] = [
    ("M", 1000.0531653147627),
    ("hx", 7.107597784466119),
    ("hy", 37.079580561353524),
    ("J0", 562.531837231882),
    ("s1x", 36.85319884947811),
    ("s1y", 0.06441400982399527),
    ("J1", 67.78449073016368),
    ("s2x", 10.904967872895638),
    ("s2y", 0.0567828349247681),
    ("J2", 13.398084636289925),
    ("Ir1", 0.7867163274892536),
    ("Ir2", 0.4890676539766472),
    ("fv1", 0.19257775529847876),
    ("fv2", 0.2900695001698692),
    ("ms", 35.7750741049111),
    ("kx_ms", 0.004168151399455135),
    ("ky_ms", 0.0033922136053672557),
    ("cx_ms", 0.0008003951057776465),
    ("cy_ms", 0.0011966114905024932),
    ("bx", -0.4461356376869924),
    ("by", 0.19994668567073656),
    ("w1", 5.840465077750729),
    ("z1", 0.006503047227366278),
    ("Pr1", 11.347687764585427),
    ("Pt_Pr1", 0.23481811107325154),
    ("phm_Pr1", 2.3058130650753523),
    ("pht_Pr1", 7.277494903400851),
    ("w2", 40.352354573106126),
    ("z2", 0.013365064822869008),
    ("Pr2", 2.348422721969768),
    ("Pt_Pr2", 0.5354634120487527),
    ("phm_Pr2", 1.0174485090150613),
    ("pht_Pr2", -1.3870221635308122),
    ("Jw", 0.08019508420859367),
    ("fw", 0.00011823836978502822),
];

/// Those that differ with the target grasped.
const MATED: [(&str, f64); 10] = [
    ("M", 1193.942832484617),
    ("hx", 199.05836828262176),
    ("hy", 229.03035105950917),
    ("J0", 942.5943628182301),
    ("s1x", 437.81703055673654),
    ("s1y", 0.06441400982399527),
    ("J1", 896.9776947007741),
    ("s2x", 480.74844057032305),
    ("s2y", 8.714669717155628),
    ("J2", 1202.919375919471),
];

fn craft() -> Plant {
    let mut plant = plant("study_case");
    let mut set = 0;
    plant.visit_quantities(&mut |name, _, quantity| {
        if let Some((_, value)) = PHYSICAL.iter().find(|(own, _)| *own == name) {
            quantity.value = *value;
            set += 1;
        }
    });
    assert_eq!(set, PHYSICAL.len());
    plant
}

fn agree(plant: &Plant, truth: &[(&str, f64)]) {
    let found = plant.planar_base_values();
    for (name, value) in truth {
        let own = found.iter().find(|own| own.name == *name).unwrap_or_else(|| panic!("{name}"));
        // rounding, lost where large moments cancel
        assert!((own.value - value).abs() < 1e-9 * value.abs().max(1e-3), "{name}: {} {value}", own.value);
    }
}

#[test]
fn base_values_are_those_of_other_equations_under_the_same_names() {
    agree(&craft(), &BASE);
    assert_eq!(craft().planar_base_values().len(), BASE.len());
}

#[test]
fn a_body_that_is_held_counts_as_part_of_the_link_that_holds_it() {
    let mut plant = craft();
    let mut target = plant.bodies.iter().find(|body| body.name == "link_2").unwrap().clone();
    let known = |values: [f64; 3]| values.map(Quantity::known);
    target.name = "target".into();
    target.parent = Some("link_2".into());
    target.joint =
        Joint { name: "grasp".into(), kind: JointKind::Fixed, position_m: known([1.898, 0.0, 0.0]), ..target.joint };
    target.mass_kg = Quantity::known(193.8896671698542);
    target.com_m = known([0.5252517366994494, 0.044653678602925476, 0.0]);
    target.inertia_com_kg_m2[2] = Quantity::known(50.58567359402011);
    plant.bodies.push(target);
    agree(&plant, &MATED);
}
