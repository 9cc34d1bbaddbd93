# contbed with the versions of requirements.lock:
#     docker build --tag contbed .
#     docker run contbed make heater
#     docker run contbed make test
FROM python:3.11-slim-bookworm

# to compile, and to mesh a .geo with gmsh
RUN apt-get update \
    && apt-get install --yes --no-install-recommends \
        make gcc libc6-dev libglu1-mesa libgl1 libxcursor1 libxft2 libxinerama1 libgomp1 \
    && rm -rf /var/lib/apt/lists/*

RUN useradd --create-home contbed
USER contbed
WORKDIR /home/contbed/project

COPY --chown=contbed:contbed requirements.lock ./
RUN python -m venv .venv && .venv/bin/pip install --no-cache-dir --requirement requirements.lock

COPY --chown=contbed:contbed . .
RUN .venv/bin/pip install --no-cache-dir --no-deps --no-build-isolation --editable . \
    && touch .venv/.test .venv/.docs .venv/.report

CMD ["make", "test"]
