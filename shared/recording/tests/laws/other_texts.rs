//! Texts that are no tables are refused in a sentence; tidy tables of databases are read.

use crate::file;
use recording::Intake;

fn lines(line: impl Fn(usize) -> String) -> String {
    (0..60).map(|k| line(k) + "\n").collect()
}

#[test]
fn a_text_that_is_no_table_is_refused_by_what_it_is() {
    let files = [
        (
            "an ArduPilot log",
            format!("FMT, 128, 89, FMT, BBnNZ, Type,Length,Name\n{}", lines(|k| format!("IMU, {k}, 0.1, 0.2"))),
        ),
        ("mavlogdump", lines(|k| format!("2024-03-05 14:59:58.{k:02}: IMU {{TimeUS : {k}, GyrX : 0.1}}"))),
        ("InfluxDB", lines(|k| format!("imu,host=a gyro=0.{k},n={k}i 17096507980000000{k:02}"))),
        ("candump", lines(|k| format!("(1709650798.0000{k:02}) can0 1A0#00{k:02}"))),
        (
            "ASC",
            format!(
                "date Tue Mar 5\nbase hex  timestamps absolute\n{}",
                lines(|k| format!("   0.0{k:02} 1  1A0  Rx   d 2 00 01"))
            ),
        ),
        ("NMEA", lines(|k| format!("$GPGGA,1235{k:02},4807.038,N,01131.000,E*47"))),
        ("ros2 topic echo", lines(|k| format!("header:\n  sec: {k}\nangular_velocity:\n  z: 0.1\n---"))),
        (
            "keys and values",
            lines(|k| format!("t=0.{k:02} {}=0.1 torque=-0.2", if k % 2 == 0 { "gyro" } else { "rate" })),
        ),
        (
            "Vicon",
            format!(
                "Trajectories\n,,hub:m1,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n{}",
                lines(|k| format!("{k},0,1,2,3"))
            ),
        ),
        (
            "OptiTrack",
            format!(
                "Format Version,1.23,Capture Frame Rate,100.0\n\n,,Rigid Body\nFrame,Time (Seconds),X\n{}",
                lines(|k| format!("{k},0.{k:02},1"))
            ),
        ),
    ];
    for (what, text) in files {
        let path = file(&format!("foreign_{}.txt", what.replace(' ', "_")), &text);
        let error = recording::read_with(&path, &Intake::default()).unwrap_err().explain();
        assert!(error.contains("this is ") && error.contains(what), "{what}: {error}");
    }
}

#[test]
fn an_annotated_table_of_influxdb_is_a_tidy_table() {
    let head = "#group,false,false,true,true,false,false,true,true\n\
                #datatype,string,long,dateTime:RFC3339,dateTime:RFC3339,dateTime:RFC3339,double,string,string\n\
                #default,_result,,,,,,,\n,result,table,_start,_stop,_time,_value,_field,_measurement\n";
    let rows = |table: usize, field: &str| {
        lines(|k| {
            format!(
                ",,{table},2024-03-05T14:00:00Z,2024-03-05T16:00:00Z,2024-03-05T15:00:00.{k:02}0Z,{k}.5,{field},imu"
            )
        })
    };
    let path = file("influx.csv", &format!("{head}{}{}", rows(0, "gyro_z"), rows(1, "torque_Nm")));
    let set = recording::read_with(&path, &Intake::default()).and_then(recording::series).unwrap();
    let found: Vec<(&str, usize, f64)> =
        set.recording.channels.iter().map(|of| (of.name.as_str(), of.value.len(), of.value[3])).collect();
    assert_eq!(found, [("gyro_z", 60, 3.5), ("torque_Nm", 60, 3.5)], "{:?}", set.notes);
}
