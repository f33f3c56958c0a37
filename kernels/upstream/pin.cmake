# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# The one version of upstream that this overlay fits.
#
# origin   Intel Embree, https://www.embree.org, https://github.com/embree/embree
# licence  Apache-2.0 (LICENSE.txt of the archive)
# archive  source package `embree` of Debian, which repacks upstream's release
#          without the PDF manuals: its checksum differs from upstream's own
# suite    the release of Debian that has this version; other releases of Debian, and
#          all of Ubuntu's that are supported, have an older or a newer one

set(EMBREE_UPSTREAM_PACKAGE "embree")
set(EMBREE_UPSTREAM_VERSION "3.13.5+dfsg")
set(EMBREE_UPSTREAM_SUITE   "bookworm")
set(EMBREE_UPSTREAM_SHA256  "1b7c5b6144230ad81b92ece884a2017fbbb433bf5416a6fca9257e0109501c63")
