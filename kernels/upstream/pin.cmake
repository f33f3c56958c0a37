# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# The version of upstream for which the patches are made.
#
# origin   Intel Embree, https://www.embree.org, https://github.com/embree/embree
# license  Apache-2.0 (LICENSE.txt of the archive)
# archive  Debian's source package `embree`, which differs from upstream's release: it has no PDF manuals
# suite    the only Debian release with this version

set(EMBREE_UPSTREAM_PACKAGE "embree")
set(EMBREE_UPSTREAM_VERSION "3.13.5+dfsg")
set(EMBREE_UPSTREAM_SUITE   "bookworm")
set(EMBREE_UPSTREAM_SHA256  "1b7c5b6144230ad81b92ece884a2017fbbb433bf5416a6fca9257e0109501c63")
