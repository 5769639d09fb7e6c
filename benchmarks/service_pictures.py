"""What the service is asked: photographs of its own model's samples, as multipart forms, with the answers expected."""

import io
import json
from dataclasses import dataclass

from PIL import Image

from benchmarks.service_process import Service, ask

WIDTH, HEIGHT, QUALITY = 640, 480, 90
BOUNDARY = "chiaro-benchmark"
HEADERS = {"Content-Type": f"multipart/form-data; boundary={BOUNDARY}"}


@dataclass(frozen=True)
class Question:
    """A picture, the body that uploads it, and the GLB that answers it."""

    jpeg: bytes
    body: bytes
    answer: bytes


def make_questions(service: Service, category: str, count: int) -> list[Question]:
    """As many pictures of different samples at different azimuths, 640 × 480 JPEG; those that are refused are left out.

    Raises:
        RuntimeError: too many of them are refused.
    """
    questions: list[Question] = []
    refusal = ""
    for seed in range(4 * count):
        jpeg = _photograph(service, category, seed)
        body = _form(jpeg, category)
        status, answer = ask(service, "POST", "/v1/reconstruct", body, HEADERS)
        if status == 200:
            questions.append(Question(jpeg, body, answer))
        else:
            refusal = f"{status}: {json.loads(answer)['detail']}"
        if len(questions) == count:
            return questions
    raise RuntimeError(
        f"expected {count} of {4 * count} samples of {category} to be answered, found {len(questions)}, and last "
        f"{refusal}; name models that were trained longer with --models"
    )


def _photograph(service: Service, category: str, seed: int) -> bytes:
    path = f"/v1/sample?category={category}&seed={seed}&azimuth_degrees={37 * seed % 360}"
    status, content = ask(service, "GET", path, b"", {"Accept": "image/png"})
    if status != 200:
        raise RuntimeError(f"{path}: expected 200, found {status}: {json.loads(content)['detail']}")
    buffer = io.BytesIO()
    with Image.open(io.BytesIO(content)) as picture:
        picture.convert("RGB").resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS).save(buffer, "JPEG", quality=QUALITY)
    return buffer.getvalue()


def _form(jpeg: bytes, category: str) -> bytes:
    return b"".join(
        (
            f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="category"\r\n\r\n{category}\r\n'.encode(),
            f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="image"; filename="a.jpg"\r\n\r\n'.encode(),
            jpeg,
            f"\r\n--{BOUNDARY}--\r\n".encode(),
        )
    )
