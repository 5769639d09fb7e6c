"""docs/api.md names everything that there is."""

import re
from dataclasses import fields
from pathlib import Path

from service.app import create_app
from service.catalogue import Catalogue
from service.http.description import describe
from service.http.schema import AnswerBody
from service.http.upload import FIELDS
from service.models import ModelReport
from service.report import PosteriorReport, ViewReport
from service.settings import Settings

TEXT = (Path(__file__).parents[2] / "docs" / "api.md").read_text()


def test_every_path_field_and_variable_is_named() -> None:
    described = describe(create_app(Catalogue(()), Settings()))["paths"]
    paths = {*described, "/docs", "/openapi.json"}
    names = {
        field.name
        for field in (*fields(AnswerBody), *fields(PosteriorReport), *fields(ViewReport), *fields(ModelReport))
    }
    variables = {f"CHIARO_{name.upper()}" for name in Settings.model_fields}
    for name in paths | names | variables:
        assert re.search(rf"`[^`]*{re.escape(name)}\b[^`]*`", TEXT), name


def test_the_form_of_a_picture_has_the_fields_that_are_named() -> None:
    (line,) = re.findall(r"^\| `POST /v1/reconstruct` \|.*$", TEXT, re.M)
    assert {"image", *re.findall(r"a text `(\w+)`", line)} == set(FIELDS)


def test_no_variable_is_named_that_is_not_there() -> None:
    named = set(re.findall(r"CHIARO_(\w+)", TEXT))
    assert named == {name.upper() for name in Settings.model_fields}
