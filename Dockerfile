# The service alone: no torch, no compiler, no root. Mount a bundle, or a directory of bundles, at /models.
FROM python:3.11-slim AS build
WORKDIR /source
COPY pyproject.toml README.md LICENSE ./
COPY imaging imaging
COPY rasteriser rasteriser
COPY service service
RUN service/page/turntable/install.sh
COPY exporter exporter
COPY trainer trainer
RUN python -m venv /opt/chiaro && /opt/chiaro/bin/pip install --no-cache-dir .

FROM python:3.11-slim
COPY --from=build /opt/chiaro /opt/chiaro
RUN useradd --system --uid 10001 --no-create-home --shell /usr/sbin/nologin chiaro
USER 10001
WORKDIR /
ENV PATH=/opt/chiaro/bin:$PATH \
    PYTHONDONTWRITEBYTECODE=1 \
    ORT_DISABLE_TELEMETRY=1 \
    CHIARO_HOST=0.0.0.0 \
    CHIARO_PORT=8000 \
    CHIARO_MODELS=/models
EXPOSE 8000
HEALTHCHECK --interval=10s --timeout=3s --start-period=10s \
    CMD ["python", "-c", "import os, urllib.request; urllib.request.urlopen(f'http://127.0.0.1:{os.environ[\"CHIARO_PORT\"]}/readyz', timeout=2)"]
ENTRYPOINT ["python", "-m", "service"]
