//! Against Pinocchio and MuJoCo: numbers committed with the script that makes them (`tests/peers`).

use super::*;
use serde_json::Value;

const GOLDEN: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/multibody.json"));

/// Both engines compute in double precision and agree with each other to about 1e-12 of the terms.
const TOLERANCE: f64 = 1e-10;

fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(Value::as_f64).collect()
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_vec(numbers(value).unwrap())
}

fn link(body: &Value) -> Link {
    let axis = vector(&body["axis"]);
    let inertia = numbers(&body["inertia_com_kg_m2"]).unwrap();
    let [xx, xy, xz, yy, yz, zz] = inertia.try_into().unwrap();
    Link {
        parent: usize::try_from(body["parent"].as_i64().unwrap()).ok(),
        joint: match body["joint"].as_str().unwrap() {
            "free_spatial" => JointKind::FreeSpatial,
            "free_planar" => JointKind::FreePlanar,
            "fixed" => JointKind::Fixed,
            "revolute" => JointKind::Revolute { axis },
            "prismatic" => JointKind::Prismatic { axis },
            other => panic!("joint {other}"),
        },
        position_m: vector(&body["position_m"]),
        rotation: Matrix3::from_row_slice(&numbers(&body["rotation"]).unwrap()),
        mass_kg: body["mass_kg"].as_f64().unwrap(),
        com_m: vector(&body["com_m"]),
        inertia_com_kg_m2: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
        armature: 0.0,
    }
}

fn near(what: &str, found: &[f64], expected: Option<Vec<f64>>, terms: &[f64]) -> usize {
    let Some(expected) = expected else { return 0 };
    assert_eq!(found.len(), expected.len(), "{what}");
    for ((f, e), terms) in found.iter().zip(&expected).zip(terms) {
        assert!((f - e).abs() <= TOLERANCE * terms, "{what}: {f} is not {e}, terms {terms}");
    }
    expected.len()
}

/// `Σ |Y_ij π_j|` per row: what was added to make an effort.
fn effort_terms(regressor: &DMatrix<f64>, parameters: &[f64]) -> Vec<f64> {
    regressor.row_iter().map(|row| row.iter().zip(parameters).map(|(y, p)| (y * p).abs()).sum()).collect()
}

fn compare(name: &str, model: &Model, state: &Value) -> usize {
    let get = |key: &str| numbers(&state[key]);
    let (q, v, tau, a) = (get("q").unwrap(), get("v").unwrap(), get("tau").unwrap(), get("a").unwrap());
    let n = model.v_len();
    let mut data = Data::new(model);
    let mut regressor = DMatrix::zeros(n, 10 * model.links_len());
    inverse_dynamics_regressor(model, &mut data, &q, &v, &a, &mut regressor);
    let terms = effort_terms(&regressor, &model.standard_parameters());
    let what = |quantity: &str| format!("{name}, {quantity}");
    let mut compared = near(&what("inverse"), &efforts(model, &q, &v, &a, &[]), get("inverse"), &terms);

    let matrix = mass(model, &q);
    let row_major: Vec<f64> = matrix.transpose().iter().copied().collect();
    let scale = vec![matrix.norm(); n * n];
    compared += near(&what("mass matrix"), &row_major, get("mass_matrix"), &scale);
    let row_major: Vec<f64> = regressor.transpose().iter().copied().collect();
    compared += near(&what("regressor"), &row_major, get("regressor"), &vec![regressor.norm(); row_major.len()]);

    let state_of = State { q: q.clone(), v: v.clone(), a, tau: tau.clone(), wrench: vec![] };
    let efforts: Vec<f64> = tau.iter().zip(&terms).map(|(tau, terms)| tau.abs() + terms).collect();
    let inverse = matrix.clone().try_inverse().unwrap().abs() * DVector::from_vec(efforts);
    let found = accelerations(model, &state_of, &[]);
    compared += near(&what("forward"), &found, get("forward"), inverse.as_slice());

    let h = momentum(model, &mut data, &q, &v);
    let reach = 1.0 + norm(&h.com);
    let size = vec![h.mass * reach * reach * (1.0 + norm(&v)); 6]; // mass · arm · speed
    let world: Vec<f64> = h.angular_about_origin.into_iter().chain(h.linear).collect();
    compared += near(&what("momentum"), &world, get("momentum_world"), &size);
    compared += near(&what("momentum about com"), &h.angular_about_com, get("momentum_com"), &size);
    compared += near(&what("com"), &h.com, get("com_world_m"), &[reach; 3]);
    let kinetic = kinetic_energy(model, &mut data, &q, &v);
    compared += near(&what("T"), &[kinetic], state["kinetic_energy_j"].as_f64().map(|t| vec![t]), &[kinetic]);
    let potential = potential_energy(model, &mut data, &q, &v);
    let weight = h.mass * norm(&model.gravity_m_s2()) * reach * 10.0;
    compared += near(&what("V"), &[potential], state["potential_energy_j"].as_f64().map(|t| vec![t]), &[weight]);
    compared
}

#[test]
fn every_quantity_of_every_case_is_that_of_pinocchio_and_mujoco() {
    let golden: Value = serde_json::from_str(GOLDEN).unwrap();
    let cases = golden["cases"].as_array().unwrap();
    let mut compared = 0;
    for case in cases {
        let links: Vec<Link> = case["bodies"].as_array().unwrap().iter().map(link).collect();
        let model = Model::new(&links, &[], vector(&case["gravity_m_s2"])).unwrap();
        for state in case["states"].as_array().unwrap() {
            compared += compare(case["name"].as_str().unwrap(), &model, state);
        }
    }
    assert!(cases.len() >= 20 && compared > 50_000, "{} cases, {compared} numbers", cases.len());
}
