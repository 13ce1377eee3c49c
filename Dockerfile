# The packages of sightline, built and installed on plain Debian; as scripts/debian.sh does without Docker:
#   docker build --build-arg RELEASE=trixie -t sightline . && docker run --rm sightline check /usr/share/sightline/scenarios/paper_7_1.toml
ARG RELEASE=bookworm
FROM debian:${RELEASE} AS build
COPY . /sightline
RUN /sightline/scripts/packages.sh build

FROM debian:${RELEASE}
COPY --from=build /sightline_*.deb /*sightline*.deb /packages/
RUN apt-get -q update && apt-get -qy install --no-install-recommends $(ls /packages/*.deb | grep -v dbgsym) && rm -rf /packages /var/lib/apt/lists/*
ENTRYPOINT ["sightline"]
