# An image in which `make all` and `make test` run, for docker, podman or buildah:
#     docker build --tag breaker .
#     docker run --rm --volume "$PWD/figures:/breaker/figures" breaker          # make all
#     docker run --rm breaker make test
# torch comes with gigabytes for graphics cards, unless its wheel for the CPU alone lies in this
# folder and the build has --build-arg PIP_FIND_LINKS=/breaker.
FROM python:3.11-slim
RUN apt-get update \
 && apt-get install --yes --no-install-recommends make \
 && rm -rf /var/lib/apt/lists/*
WORKDIR /breaker
ARG PIP_FIND_LINKS
ARG PIP_NO_CACHE_DIR=1
COPY Makefile *.whl ./
COPY envs/requirements.lock envs/
RUN make .venv/.pinned
COPY . .
RUN make environment
ENV PATH=/breaker/.venv/bin:$PATH
CMD ["make", "all"]
