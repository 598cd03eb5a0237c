"""Motors: the keys of a motor file, as attributes."""

import pytest
from conftest import program

import motorlab as ml


def test_a_motor_reads_back_as_it_was_saved(tmp_path):
    motor = ml.Motor(
        resistance_ohm=8.25,
        tolerance={"inertia_kg_m2": 0.1},
        effects={"backlash": {"gap_rad": 0.02}, "cogging#2": {"torque_nm": 0.003, "cycles_per_rev": 28}},
    )
    path = tmp_path / "motor.toml"
    motor.save(path)
    assert ml.Motor.load(path) == motor
    assert ml.Motor.load(path).tolerance == {"inertia_kg_m2": 0.1}
    assert dict(motor)["resistance_ohm"] == motor.resistance_ohm == 8.25


def test_a_file_that_exists_is_replaced_only_where_that_is_said(tmp_path):
    path = tmp_path / "motor.toml"
    path.write_text("supply_v = 3.0\n")
    with pytest.raises(ml.MotorlabError, match="exists and is not overwritten"):
        ml.Motor().save(path)
    assert path.read_text() == "supply_v = 3.0\n"
    ml.Motor(supply_v=6).save(path, overwrite=True)
    assert ml.Motor.load(path).supply_v == 6


@pytest.mark.parametrize(
    "text",
    ["resistence_ohm = 8", "resistance_ohm = -1", "[effects.backlas]\n", "[effects.backlash]\ngap = 1", "supply_v = 'x'", "=="],
)
def test_wrong_motor_files_are_said_in_the_words_of_the_program(tmp_path, text):
    path = tmp_path / "motor.toml"
    path.write_text(text)
    with pytest.raises(ml.MotorlabError) as error:
        ml.Motor.load(path)
    said = program("simulate", "--motor", path, "--duration", "0.1").stderr
    assert f"error: {error.value}" in said
    assert error.value.kind == "bad_input"
    assert error.value.file == str(path)


def test_values_that_no_motor_has_are_refused_and_leave_the_motor_as_it_was():
    motor = ml.Motor()
    for key, value in [("inertia_kg_m2", -1.0), ("inertia_kg_m2", float("nan")), ("supply_v", float("inf"))]:
        with pytest.raises(ml.MotorlabError, match=key):
            motor[key] = value
    with pytest.raises(AttributeError, match="resistance_ohm"):
        motor.resistance
    with pytest.raises(ml.MotorlabError, match="did you mean 'backlash'"):
        motor.set_effect("backlas")
    with pytest.raises(ml.MotorlabError, match="tolerance"):
        ml.Motor(tolerance={"supply_v": -1.0})
    assert motor == ml.Motor()
