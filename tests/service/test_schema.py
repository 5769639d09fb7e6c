"""The service keeps what its OpenAPI document promises, whatever that document, or its breach, has a client send."""

import warnings

import httpx
import pytest
from hypothesis import HealthCheck, Phase, given, settings

from service.app import create_app
from service.catalogue import Catalogue
from service.http.description import describe
from service.settings import Settings

with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)
    import schemathesis
    from schemathesis import Case, GenerationMode
    from schemathesis.checks import not_a_server_error
    from schemathesis.specs.openapi.checks import (
        content_type_conformance,
        response_headers_conformance,
        response_schema_conformance,
        status_code_conformance,
        unsupported_method,
    )

CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_headers_conformance,
    response_schema_conformance,
    unsupported_method,
]
DOCUMENT = describe(create_app(Catalogue(()), Settings()))
OPERATIONS = {found.ok().label: found.ok() for found in schemathesis.openapi.from_dict(DOCUMENT).get_all_operations()}
# Where nothing can be sent, nothing can be sent wrongly.
CASES = [
    (label, mode)
    for label, operation in OPERATIONS.items()
    for mode in GenerationMode
    if mode.is_positive or {"parameters", "requestBody"} & set(operation.definition.raw)
]


@pytest.mark.parametrize(("label", "mode"), CASES)
def test_answers_are_those_of_the_document(label: str, mode: GenerationMode, client: httpx.Client) -> None:
    @given(case=OPERATIONS[label].as_strategy(generation_mode=mode))
    @settings(
        max_examples=20,
        deadline=None,
        derandomize=True,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    def answers(case: Case) -> None:
        case.validate_response(case.call(base_url=str(client.base_url)), checks=CHECKS)

    answers()
