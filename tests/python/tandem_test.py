#!/usr/bin/env python3
"""The Python module: expected values are closed forms and those of the reference analysis."""

import os
import signal
import threading
import time
import unittest

import numpy as np

import tandem

HAND_COUPLERS = "coupler.k12.stiffness,coupler.k21.stiffness"
OWN_COUPLERS = "coupler.k11.stiffness,coupler.k22.stiffness"


class Scenes(unittest.TestCase):
    def test_edits_reach_the_scene_and_do_not_change_the_original(self):
        scene = tandem.Scene("axis_distributed")
        edited = scene.edited({"object.box.mass": 0.5})
        self.assertNotEqual(scene.hash, edited.hash)
        self.assertEqual(scene.hash, tandem.Scene("axis_distributed").hash)
        self.assertEqual(edited.hash, tandem.Scene("axis_distributed", {"object.box.mass": 0.5}).hash)
        self.assertEqual((scene.space, scene.architecture, scene.users),
                         ("axis", "distributed", ["1", "2"]))
        self.assertEqual(scene.tick, 1 / 1024)

    def test_text_reads_back_to_the_same_scene(self):
        for name in tandem.scene_names():
            scene = tandem.Scene(name)
            self.assertEqual(tandem.Scene.from_text(scene.text).text, scene.text, name)

    def test_dir_lists_what_is_offered_and_nothing_else(self):
        offered = [name for name in dir(tandem) if not name.startswith("__")]
        self.assertEqual(offered, sorted(tandem.__all__))

    def test_wrong_input_is_named(self):
        with self.assertRaisesRegex(tandem.SceneError, "axis_distributed"):
            tandem.Scene("axis_distribute")
        with self.assertRaisesRegex(ValueError, "object.box.mass.*-1"):
            tandem.Scene("axis_distributed", {"object.box.mass": -1})
        scene = tandem.Scene("axis_distributed")
        with self.assertRaisesRegex(ValueError, "seconds is nan"):
            tandem.simulate(scene, float("nan"))
        with self.assertRaisesRegex(ValueError, "delay_packets is -1"):
            tandem.judge(scene, -1)
        with self.assertRaisesRegex(ValueError, "x_range"):
            tandem.stability_map(scene, OWN_COUPLERS, (5, 1), HAND_COUPLERS, (0, 1))
        with self.assertRaisesRegex(ValueError, "no user '3'"):
            tandem.damping(scene, "3")
        with self.assertRaisesRegex(ValueError, "road"):
            tandem.transition_matrix(scene, road="scenic")


class Sessions(unittest.TestCase):
    def test_shapes_and_times(self):
        t = tandem.simulate(tandem.Scene("box_distributed"), 0.5, every=4)
        self.assertEqual(t.time.shape, (128,))
        self.assertEqual(t.poses.shape, (128, 2, 1, 3))
        self.assertEqual(t.positions.shape, (128, 4, 2))
        self.assertEqual(t.forces.shape, (128, 4, 2))
        self.assertEqual(len(t.fingers), 4)
        np.testing.assert_array_equal(t.time, np.arange(4, 513, 4) / 1024)
        self.assertEqual(t.packets_sent, 2 * 64)

    def test_same_seed_same_bits(self):
        scene = tandem.Scene("box_distributed")
        options = dict(link_delay=0.004, jitter=0.002, loss=0.1)
        a = tandem.simulate(scene, 5, seed=7, **options)
        b = tandem.simulate(scene, 5, seed=7, **options)
        c = tandem.simulate(scene, 5, seed=8, **options)
        np.testing.assert_array_equal(a.poses, b.poses)
        self.assertFalse(np.array_equal(a.poses, c.poses))
        self.assertLess(a.packets_accepted, a.packets_sent)

    def test_ctrl_c_ends_a_run(self):
        threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        start = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            tandem.simulate(tandem.Scene("box_distributed"), 100000, every=1000000)
        self.assertLess(time.monotonic() - start, 10)  # the run would take over a minute


class Analysis(unittest.TestCase):
    def test_limit_of_a_held_coupler_is_two_b_over_T(self):
        scene = tandem.Scene("axis_single", {"coupler.k.damping": 5})
        limits = tandem.stable_intervals(scene, "coupler.k.stiffness", (0.5, 4e5))
        self.assertEqual(limits.shape, (1, 2))
        # (3.18) with two free masses and z = 1 removed: 2 b / T.
        self.assertAlmostEqual(limits[0, 1] / (2 * 5 * 1024), 1, delta=1e-6)

    def test_drag_of_the_distributed_scene(self):
        scene = tandem.Scene("axis_distributed")
        # Reference analysis, Table 6.1, round trip of 0 and 1 packets.
        self.assertAlmostEqual(tandem.damping(scene).damping, 2.0395358830, delta=1e-9)
        self.assertAlmostEqual(tandem.damping(scene, delay_packets=1).damping, 4.2565966938,
                               delta=1e-9)

    def test_eigenvalues_of_the_matrix_are_the_judged_ones_and_one(self):
        scene = tandem.Scene("axis_distributed")
        judged = tandem.judge(scene, 1)
        z = np.linalg.eigvals(tandem.transition_matrix(scene, 1, road="resampled"))
        z = z[np.argsort(-abs(z))]
        self.assertAlmostEqual(abs(z[0] - 1), 0, delta=1e-9)  # translation
        self.assertAlmostEqual(abs(z[1]), judged.radius, delta=1e-9)
        self.assertTrue(judged.stable)

    def test_slow_admittance_is_one_over_the_drag(self):
        scene = tandem.Scene("axis_distributed")
        drag = tandem.damping(scene, delay_packets=2).sampled_damping
        y = tandem.admittance(scene, [[1e-4]], delay_packets=2)
        self.assertEqual(y.shape, (1, 1))
        # First order in omega is imaginary, so the magnitude is off by (omega m / b)^2 / 2.
        self.assertAlmostEqual(abs(y[0, 0]) * drag, 1, delta=1e-8)

    def test_boundary_separates_the_map(self):
        scene = tandem.Scene("axis_distributed")
        args = (OWN_COUPLERS, (0.0, 4000.0), HAND_COUPLERS, (0.0, 4000.0))
        stable = tandem.stability_map(scene, *args, shape=(20, 20), delay_packets=2)
        self.assertTrue(stable.any() and not stable.all())
        ends = tandem.stability_boundary(scene, *args, cells=20, delay_packets=2)
        for x, y in ends[::7, 0]:
            edit = lambda k: tandem.judge(scene.edited(
                {"coupler.k11.stiffness": x, "coupler.k22.stiffness": x,
                 "coupler.k12.stiffness": k, "coupler.k21.stiffness": k}), 2)
            self.assertAlmostEqual(edit(y).radius, 1, delta=1e-5)


if __name__ == "__main__":
    unittest.main()
