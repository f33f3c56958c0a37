#!/bin/bash
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests the command line of cbvh_bench: one clear line and a nonzero status for invalid names, and a record that
# contains everything required to repeat the measurement.
#
# usage: bench_cli.sh PATH/TO/cbvh_bench PATH/TO/libembree3.so.3

set -u
program=$1
library=$2
. "$(dirname -- "$0")/cli.sh"

# refuses PATTERN ARGUMENT...: expects status 1, one matching line on stderr, and no record.
refuses() {
  local pattern=$1
  shift
  expect_refusal "$pattern" --json "$folder/refused.json" "$@"
  [ ! -e "$folder/refused.json" ] || complain "a record was written: $*"
}

refuses "scene 'teapot'.*cube, frog" --scene teapot
refuses "scene 'teapot'.*cube, frog" --scene cube,teapot
refuses "scene 'cube,cube'.*'cube' twice" --scene cube,cube
refuses "cube:high'.*amplitude" --scene cube:high
refuses "scene .*--cage .*--mesh "
refuses "height .*--cage" --scene cube --height "$folder/map.exr"
refuses "amplitude .*--cage.*cube:0.45" --scene cube --amplitude 0.45
refuses "count .*--scene herd" --scene herd,cube --count 2
refuses "missing.obj: " --cage "$folder/missing.obj"
refuses "missing.exr" --cage "$folder/quad.obj" --height "$folder/missing.exr"
refuses "representation 'mesh'.*naive, naive-compact, grid, cgrid, cvoxel, cleaf, cleaf-only, cvert [a-z]* ctile" \
  --scene cube --representation mesh
refuses "representation 'cbvh.leaf' .*repeated" --scene cube --representation Leaf,cbvh.leaf
refuses "option --leaves-only" --scene cube --leaves-only
refuses "level '2,02' .*2 twice" --scene cube --level 2,02
refuses "frame level '9'.* 0 to 8" --scene cube --frame-level 2,9
refuses "level '9'.* 0 to 8" --scene cube --level 4,9
refuses "view 'side'.*full, close" --scene cube --view full,side
refuses "ray-set 'random'.*coherent" --scene cube --ray-set random
refuses "query 'all'.*closest" --scene cube --query all
refuses "mode 'packet5'.*packet8" --scene cube --mode packet5
refuses "mode 'single,'.*empty" --scene cube --mode single,
refuses "threads 'many'.* 0 to 1024" --scene cube --threads many
refuses "repeat -1.* 0 to 1000" --scene cube --repeat -1
refuses "reference-level 9.* 0 to 8" --scene cube --reference-level 9
refuses "check 'holes'.*leaks" --scene cube --check leaks,holes
refuses "check .*--motion" --scene cube --motion turn --check leaks
refuses "position '1,2'.*x,y,z" --scene cube --position 1,2
refuses "max-error-diagonals -1.* 0" --scene cube --max-error-diagonals -1
refuses "$folder/quad.obj/pictures: .*Not a directory" --scene cube --pictures "$folder/quad.obj/pictures"

# A record of two levels, with pictures.
"$program" --scene cube --level 2,3 --view full,close --frame-level 1 \
  --representation naive,naive-compact,Voxel,cbvh.leaf,leaf-only \
  --ray-set coherent,incoherent --query closest,any --mode single,packet8,stream --threads 1 \
  --rays 500 --repeat 1 --size 40x32 --true-surface 200 --reference-level 4 --pictures "$folder/pictures" \
  --json "$folder/good.json" \
  > "$folder/stdout" 2> "$folder/stderr" || complain "cube: $(cat "$folder/stderr")"
for word in commit isa thread; do
  grep -q "$word" "$folder/stdout" || complain "no message about $word on stdout"
done
grep -q "^  cLEAF^1 .*% of the quads stored as cVERT.* error median 0.* p99 " "$folder/stdout" ||
  complain "no message about quads stored as cVERT"
grep -q "RMSE" "$folder/stdout" && complain "an RMSE outside of the paper's section"
[ -z "$(find "$folder" -name '*cbvh-part*')" ] || complain "temporary files are left"
/usr/bin/python3 -B - "$folder" << 'PYTHON' || complain "the record is wrong"
import json, os, sys
folder = sys.argv[1]
record = json.load(open(folder + "/good.json"))
run = record["run"]
assert record["format"] == "cbvh-bench" and record["complete"]
for key in ("command", "date", "commit", "compiler", "flags", "build_type", "cpu", "hardware_threads", "system",
            "settings"):
    assert key in run, key
assert run["command"].startswith("cbvh_bench --scene cube --level 2,3"), run["command"]
assert run["settings"]["true_surface_hits"] == 200
assert run["settings"]["seed"] == 1 and run["settings"]["repeat"] == 1 and run["settings"]["reference_level"] == 4
assert [g["level"] for g in record["groups"]] == [2, 3]
for group in record["groups"]:
    labels = [r["representation"] for r in group["results"]]
    assert labels == ["GRID", "NAIVE", "NAIVE-compact", "cVOXEL^1", "cLEAF^1", "cLEAF-only^1"], labels
    naive, compact = group["results"][1:3]
    assert compact["kind"] == "NAIVE-compact" and "frame_level" not in compact, compact
    assert compact["memory"]["live_bytes"] < 0.8 * naive["memory"]["live_bytes"], "Embree's compact mode is off"
    assert [s["hits"] for s in compact["speed"]] == [s["hits"] for s in naive["speed"]], "the same triangles"
    compressed = [r for r in group["results"] if "compression" in r["memory"]]
    exact = {r["kind"]: r["memory"]["compression"]["fallback_quads_share"] for r in compressed}
    assert 0 < exact["cLEAF"] <= 1 and exact["cLEAF-only"] == exact["cVOXEL"] == 0, exact
    for r in group["results"]:
        m = r["memory"]
        assert 0 < m["live_bytes"] <= m["peak_bytes"] and m["large_page_bytes"] >= 0
        assert m["inner_bytes"] + m["leaf_bytes"] == m["live_bytes"], (r["representation"], m)
        assert len(r["speed"]) == 2 * 2 * 2 * 3 and len(r["views"]) == 2
        for s in r["speed"]:
            assert len(s["seconds"]) == 1 and s["seconds"][0] > 0 and s["hits"] <= s["rays"]
            if r["representation"] == "GRID":
                assert s["relative_to_grid"]["median"] == 1
            same = [t["hits"] for t in r["speed"] if (t["view"], t["ray_set"]) == (s["view"], s["ray_set"])]
            assert max(same) - min(same) <= 0.01 * s["rays"], (r["representation"], s["view"], s["ray_set"], same)
        for v in r["views"]:
            assert os.path.isfile(os.path.join(folder, "pictures", v["picture"]))
            assert v["errors_to_reference_level"]["both_hit"] > 0
            true = v["errors_to_true_surface"]
            assert 0 < true["hits"] <= 200, true
            assert 0 < true["median_pixels"] <= true["p99_pixels"] <= true["max_pixels"], true
            e = v["errors"]
            keys = {"rmse_pixels", "median_pixels", "p99_pixels", "max_pixels", "bias_pixels", "false_hits", "misses"}
            assert keys <= set(e)
            if r["representation"] == "GRID":
                assert e["max_pixels"] == 0 and e["false_hits"] == e["misses"] == 0
            else:
                assert os.path.isfile(os.path.join(folder, "pictures", v["error_map"]))
PYTHON

# The command in a record can be pasted into a shell.
odd="$folder/it's {1}.json"
"$program" --scene cube --level 1 --size 8x8 --repeat 0 --true-surface 0 --representation grid --json "$odd" \
  > "$folder/stdout" 2> "$folder/stderr" || complain "odd name: $(cat "$folder/stderr")"
/usr/bin/python3 -B -c 'import json, shlex, sys
assert shlex.split(json.load(open(sys.argv[1]))["run"]["command"])[-1] == sys.argv[1]' "$odd" ||
  complain "the command does not quote a name: $(cat "$odd")"

# Moving geometry compared with GRID's motion blur, with random ray times: a static GRID would be far away.
"$program" --scene cube --motion turn --level 3 --representation cvert --rays 500 --repeat 1 --size 40x32 \
  --json "$folder/moving.json" \
  > "$folder/stdout" 2> "$folder/stderr" || complain "motion: $(cat "$folder/stderr")"
grep -q "warning: cvert" "$folder/stderr" && complain "a warning about cVERT in motion: $(cat "$folder/stderr")"
"$program" --scene cube,cube:0.1 --motion turn --level 2 --representation cgrid,cleaf-only --repeat 0 --size 16x16 \
  > "$folder/stdout" 2> "$folder/framed.err" || complain "motion of frames: $(cat "$folder/framed.err")"
[ "$(grep -c "^cbvh_bench: warning: cgrid .*cVERT" "$folder/framed.err")" = 1 ] &&
  grep -q "^cbvh_bench: warning: cleaf-only .*GRID" "$folder/framed.err" ||
  complain "no warning about blocks with frames: $(cat "$folder/framed.err")"
/usr/bin/python3 -B -c '
import json, sys
group = json.load(open(sys.argv[1]))["groups"][0]
assert group["scene"] == "cube-turn", group["scene"]
grid, cvert = group["results"]
assert "errors_to_true_surface" not in cvert["views"][0]
e = cvert["views"][0]["errors"]
assert e["both_hit"] > 100 and e["p99_pixels"] < 0.1 and e["false_hits"] + e["misses"] <= 2, e
assert cvert["memory"]["compression"]["quads"] > 0 and cvert["speed"][0]["hits"] > 0' "$folder/moving.json" ||
  complain "a turning cube is wrong: $(cat "$folder/moving.json")"

# Leaks and shadows of a closed surface that is far from the origin.
"$program" --scene cube --level 3 --representation cgrid,cleaf-only^auto --max-error-diagonals 0.01 \
  --position 1000,0,-50 --repeat 0 --size 40x32 --check leaks,offsets,crossings --check-rays 20000 \
  --json "$folder/checks.json" > "$folder/stdout" 2> "$folder/stderr" ||
  complain "checks: $(cat "$folder/stderr")"
grep -q "leaks of" "$folder/stdout" || complain "no message about leaks"
/usr/bin/python3 -B -c '
import json, sys
group = json.load(open(sys.argv[1]))["groups"][0]
grid, cgrid, cleaf = group["results"]
assert "leaks" not in grid and group["quad_width"] > 0
for r in (cgrid, cleaf):
    leaks, shadows = r["leaks"], r["shadows"]
    assert 10000 < leaks["aimed_rays"] < leaks["rays"] <= 20000, leaks
    assert len(shadows) > 10 and all(s["rays"] > s["occluded"] for s in shadows)
assert cleaf["leaks"]["missed"] == {"closest": 0, "any": 0, "through": 0}, cleaf["leaks"]
assert all(s["errors"] == {"false_occlusions": 0, "false_passes": 0} for s in cgrid["shadows"])
assert any(0 < s["flipped_rays"] < s["rays"] and sum(s["flipped_errors"].values()) for s in cleaf["shadows"])
lines = open(sys.argv[2]).read()
for s in cgrid["shadows"] + cleaf["shadows"]:
    same, flipped = (1000 * sum(s[kind + "_errors"].values()) / max(1, s[kind + "_rays"])
                     for kind in ("same_hit", "flipped"))
    line = "of %d rays with the same hit %.3f, of %d with a flipped normal %.3f;" % (s["same_hit_rays"], same,
                                                                                   s["flipped_rays"], flipped)
    assert line in lines, line
crossed = cgrid["crossings"][0]
assert crossed["rays"] == 40*32 and crossed["crossings"] > 100, crossed
assert crossed["different_parities"] <= 2, crossed' "$folder/checks.json" "$folder/stdout" ||
  complain "leaks or shadows are wrong: $(cat "$folder/checks.json")"

# Libraries. The program must call each of Embree's functions through its own table.
unslotted=$(nm -D --undefined-only "$program" | grep -o ' U rtc.*' | grep -v Vulkan)
[ -z "$unslotted" ] || complain "not in tutorials/bench/embree_calls.cpp:$unslotted"
mkdir "$folder/a" "$folder/b" "$folder/empty"
cp "$library" "$folder/a/libembree3.so.3"
cp "$library" "$folder/b/libembree3.so.3"
refuses "library '.*missing.so: .*No such file" --scene cube --library "$folder/a,$folder/missing.so"
refuses "quad.obj: \(invalid ELF header\|file too short\)" --scene cube --library "$folder/quad.obj"
refuses "libtbb.*rtcNewDevice" --scene cube --library "$(ldd "$library" | awk '$1 ~ "^libtbb.so" { print $3 }')"
refuses "library '$folder/empty'.* libembree3.so.3" --scene cube --library "$folder/empty"
refuses "library: .*$folder/a/libembree3.so.3 .*same" --scene cube --library "$folder/a,$folder/a/libembree3.so.3"
refuses "library .*--device vulkan" --scene cube --library "$folder/a" --device vulkan

# A library and its copy: the same hits, at about the same speed.
"$program" --scene cube --level 4 --library "$folder/a,$folder/b/libembree3.so.3" --representation grid,cleaf,cvert \
  --query closest,any --mode single,packet4,stream --rays 2000 --repeat 3 --size 64x64 --true-surface 0 \
  --json "$folder/copies.json" > "$folder/stdout" 2> "$folder/stderr" || complain "copies: $(cat "$folder/stderr")"
grep -q "library B ($folder/b/libembree3.so.3), Embree 3.13" "$folder/stdout" || complain "no message about library B"
grep -q "rays are identical to library A" "$folder/stdout" ||
  complain "no message about the hits: $(cat "$folder/stdout")"
grep -q "Mrays/s.* of GRID, spread .* of A, spread" "$folder/stdout" ||
  complain "no message about the ratio of the libraries"
/usr/bin/python3 -B - "$folder" << 'PYTHON' || complain "the record of two libraries is wrong"
import json, sys
record = json.load(open(sys.argv[1] + "/copies.json"))
a, b = record["run"]["libraries"]
assert (a["name"], b["name"]) == ("A", "B") and a["isas"] == b["isas"] != [] and a["compresses"], (a, b)
assert a["path"] == sys.argv[1] + "/a/libembree3.so.3", a
results = record["groups"][0]["results"]
rows = [(r["representation"], r["library"]) for r in results]
assert rows == [(name, library) for name in ("GRID", "cLEAF", "cVERT") for library in "AB"], rows
for r in results:
    assert len(r["speed"]) == 2 * 2 * 3
    for s in r["speed"]:
        assert ("relative_to_first_library" in s) == (r["library"] == "B"), s
    if r["library"] == "A":
        assert "hit_agreement" not in r
        continue
    assert len(r["hit_agreement"]) == 2 * 2 * 3
    for h in r["hit_agreement"]:
        assert h["rays"] > 0 and h["different_rays"] == 0, h
    ratios = sorted(s["relative_to_first_library"]["median"] for s in r["speed"])
    assert 0.5 < ratios[len(ratios) // 2] < 2, ratios
PYTHON

# A library without compression, like stock Embree, and one that lacks a function: modified names in new files, so
# that loaded ones do not change.
sed 's/rtcSetGeometryCompression/rtcNotGeometryCompression/' "$library" > "$folder/a/libembree3.so.3"
"$program" --scene cube --level 3 --library "$folder/a,$folder/b" --representation naive,cvert --rays 500 --repeat 1 \
  --size 32x32 --true-surface 0 --json "$folder/stock.json" > "$folder/stdout" 2> "$folder/stderr" ||
  complain "a library without compression: $(cat "$folder/stderr")"
grep -q "cVERT .*library A ($folder/a/libembree3.so.3)" "$folder/stderr" || complain "no message about what is left out"
/usr/bin/python3 -B - "$folder" << 'PYTHON' || complain "the record of a library without compression is wrong"
import json, sys
results = json.load(open(sys.argv[1] + "/stock.json"))["groups"][0]["results"]
measured = [(r["representation"], r["library"]) for r in results if "skipped" not in r]
assert measured == [("GRID", "A"), ("GRID", "B"), ("NAIVE", "A"), ("NAIVE", "B"), ("cVERT", "B")], measured
assert [(r["representation"], r["library"]) for r in results if "skipped" in r] == [("cVERT", "A")]
for r in results:
    ratios = ["relative_to_first_library" in s for s in r.get("speed", [])]
    assert all(x == (r["library"] == "B" and r["representation"] != "cVERT") for x in ratios), r["representation"]
PYTHON
sed 's/rtcOccluded8/rtcOccludedX/' "$library" > "$folder/a/libembree3.so.3"
refuses "library A ($folder/a/libembree3.so.3) .*rtcOccluded8" --scene cube --level 2 --library "$folder/a" \
  --representation grid --query any --mode packet8 --repeat 1 --size 32x32

# Options of the scene: two copies have twice the faces, and a separate name.
"$program" --scene herd --count 2 --mapping atlas --level 0 --representation grid --repeat 0 --size 16x16 \
  --map-folder "$folder/maps" --json "$folder/two.json" > /dev/null 2> "$folder/stderr" ||
  complain "herd: $(cat "$folder/stderr")"
"$program" --scene trex --mapping atlas --level 0 --representation grid --repeat 0 --size 16x16 \
  --map-folder "$folder/maps" --json "$folder/one.json" > /dev/null 2> "$folder/stderr" ||
  complain "trex: $(cat "$folder/stderr")"
/usr/bin/python3 -B - "$folder" << 'PYTHON' || complain "two copies are not twice one"
import json, sys
one, two = (json.load(open(f"{sys.argv[1]}/{name}.json"))["groups"][0] for name in ("one", "two"))
assert (one["scene"], two["scene"]) == ("trex-atlas", "herd-atlas-2")
assert 0 < 2 * one["faces"] == two["faces"] and 2 * one["quads"] == two["quads"]
PYTHON

# Ctrl-C after the first level: status 130, and the record contains the complete first level.
expect_cancellation "[ -e '$folder/half.json' ]" --scene cube --level 2,8,7 --representation grid,cleaf --rays 2000 \
  --repeat 10 --size 32x32 --json "$folder/half.json"
/usr/bin/python3 -B -c '
import json, sys
record = json.load(open(sys.argv[1]))
assert not record["complete"] and [g["level"] for g in record["groups"]] == [2]' "$folder/half.json" ||
  complain "the first level is lost"

finish
