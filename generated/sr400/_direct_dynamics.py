"""Direct dynamic model through the inertia matrix of sr400 [8]: 371x 315+, 8 sin/cos a call; 7x 0+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 354700140  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (D2, D3, D4, RL4, D8) = p

    # Forward recursion: velocities, accelerations, wrenches, joint 3 (elbow) [1], [3], [6], [12].
    vd3_za = 2.0*D3

    # Composite inertias and inertia matrix, joint 7 (crank) [8], [13].
    J7_cyyb = 10.0*D8
    J3_cxza = 31.0*RL4
    J3_czzc = 31.0*D4

    # Composite inertias and inertia matrix, joint 2 (shoulder) [8], [13].
    J2_cyya = 71.0*D3

    # Composite inertias and inertia matrix, joint 1 (waist) [8], [13].
    J1_czzb = 35.0*D2
    J1_czzd = 131.0*D2
    return (
        D2, D3, D4, RL4, D8, vd3_za, J7_cyyb, J3_cxza, J3_czzc, J2_cyya, J1_czzb, J1_czzd,
    )


def program(_f, q, qd, tau, c):
    (_, th2, th4, th5, _, th7) = q
    (qd1, qd2, qd4, qd5, qd6, qd7) = qd
    (tau1, tau2, tau4, tau5, tau6, tau7) = tau
    (
        D2, D3, D4, RL4, D8, vd3_za, J7_cyyb, J3_cxza, J3_czzc, J2_cyya, J1_czzb, J1_czzd,
    ) = c

    # Forward recursion: velocities, accelerations, wrenches, joint 1 (waist) [1], [3], [6], [12].
    ww1_zz = qd1*qd1

    # Forward recursion: velocities, accelerations, wrenches, joint 2 (shoulder) [1], [3], [6], [12].
    sin_th2 = _f.sin(th2)
    cos_th2 = _f.cos(th2)
    w2_x = -qd1*sin_th2
    w2_y = -qd1*cos_th2
    ww2_yz = qd2*w2_y
    ww2_xz = qd2*w2_x
    ww2_xx = w2_x*w2_x
    ww2_xy = w2_x*w2_y
    ww2_zz = qd2*qd2
    Fb2_5a = ww2_xx - ww2_zz
    vd2_xa = D2*ww1_zz
    vd2_x = -(cos_th2*vd2_xa + 9.81*sin_th2)
    vd2_y = sin_th2*vd2_xa - 9.81*cos_th2
    Fb2_3 = 48.0*ww2_xz - 3.0*ww1_zz
    Fb2_6 = 24.0*vd2_y + 13.0*ww2_xy
    Fb2_4 = 0.6*ww2_yz - (3.0*vd2_y + 1.2*ww2_xy)
    Fb2_5 = 3.0*vd2_x + 1.2*Fb2_5a - 26.6*ww2_xz

    # Forward recursion: velocities, accelerations, wrenches, joint 3 (elbow) [1], [3], [6], [12].
    sin_th7 = _f.sin(th7)
    cos_th7 = _f.cos(th7)
    sin3_theta = -(cos_th2*cos_th7 + sin_th2*sin_th7)
    cos3_theta = cos_th2*sin_th7 - sin_th2*cos_th7
    w3_x = cos3_theta*w2_x + sin3_theta*w2_y
    w3_y = cos3_theta*w2_y - sin3_theta*w2_x
    w3_z = qd2 - (qd2 - qd7)
    vd3_xa = ww1_zz - Fb2_5a
    ww3_yz = w3_y*w3_z
    ww3_xz = w3_x*w3_z
    ww3_xx = w3_x*w3_x
    ww3_xy = w3_x*w3_y
    ww3_zz = w3_z*w3_z
    Fb3_1a = ww1_zz - (ww3_xx - ww3_zz)
    Fb3_2a = ww3_xx + ww3_zz
    Fb3_4a = 2.0*ww3_xz
    Fb3_5a = -2.0*ww3_yz
    vd3_xb = D3*vd3_xa - vd2_x
    vd3_xc = vd2_y + D3*ww2_xy
    vd3_x = sin3_theta*vd3_xc - cos3_theta*vd3_xb
    vd3_y = sin3_theta*vd3_xb + cos3_theta*vd3_xc
    Fb3_1 = 40.0*vd3_x - (4.0*Fb3_1a - 10.0*ww3_xy)
    Fb3_2 = 40.0*vd3_y - (10.0*Fb3_2a - 4.0*ww3_xy)
    Fb3_6 = Fb3_1a - Fb3_2a - 3.8*ww3_xy - (10.0*vd3_x - 4.0*vd3_y)
    vd3_z = vd3_za*ww2_xz
    Fb3_3 = 8.0*ww3_xz + 20.0*ww3_yz + 40.0*vd3_z
    Fb3_4 = Fb3_4a + 10.0*vd3_z + 9.2*ww3_yz
    Fb3_5 = Fb3_5a - 4.0*vd3_z - 1.6*ww3_xz

    # Forward recursion: velocities, accelerations, wrenches, joint 4 (wrist_1) [1], [3], [6], [12].
    sin_th4 = _f.sin(th4)
    cos_th4 = _f.cos(th4)
    w4_x = cos_th4*w3_x - sin_th4*w3_z
    w4_y = -(sin_th4*w3_x + cos_th4*w3_z)
    w4_z = qd4 + w3_y
    wd4_ya = -(cos_th4*ww3_xy + sin_th4*Fb3_5a)
    wd4_xa = cos_th4*Fb3_5a - sin_th4*ww3_xy
    ww4_yz = w4_y*w4_z
    wd4_x = ww4_yz - wd4_xa
    ww4_xz = w4_x*w4_z
    wd4_y = -(wd4_ya + ww4_xz)
    ww4_xy = w4_x*w4_y
    vd4_xa = vd3_x - D4*Fb3_1a
    vd4_z = vd3_y + D4*ww3_xy - RL4*Fb3_2a
    Fb4_3 = 20.0*vd4_z + 6.0*Fb3_2a
    Fb4_6 = -0.1*ww3_xz
    vd4_xb = D4*Fb3_4a + vd3_z
    vd4_x = cos_th4*vd4_xa - sin_th4*vd4_xb - RL4*wd4_ya
    vd4_y = RL4*wd4_xa - (sin_th4*vd4_xa + cos_th4*vd4_xb)
    Fb4_1 = 6.0*wd4_ya + 20.0*vd4_x
    Fb4_2 = 20.0*vd4_y - 6.0*wd4_xa
    Fb4_4 = 2.6*wd4_x + 6.0*vd4_y - 2.5*ww4_yz
    Fb4_5 = 2.5*ww4_xz - (6.0*vd4_x - 2.6*wd4_y)

    # Forward recursion: velocities, accelerations, wrenches, joint 5 (wrist_2) [1], [3], [6], [12].
    sin_th5 = _f.sin(th5)
    cos_th5 = _f.cos(th5)
    w5_x = cos_th5*w4_x + sin_th5*w4_z
    w5_y = cos_th5*w4_z - sin_th5*w4_x
    w5_z = qd5 - w4_y
    wd5_xa = ww3_xz + ww4_xy
    wd5_xb = -(ww4_yz + wd4_x)
    ww5_yz = w5_y*w5_z
    wd5_x = ww5_yz - (sin_th5*wd5_xa + cos_th5*wd5_xb)
    ww5_xz = w5_x*w5_z
    wd5_y = -(cos_th5*wd5_xa - sin_th5*wd5_xb + ww5_xz)
    ww5_xx = w5_x*w5_x
    ww5_xy = w5_x*w5_y
    ww5_zz = w5_z*w5_z
    Fb5_1a = -(wd4_y + ww5_xy)
    Fb5_2a = ww5_xx + ww5_zz
    Fb5_3a = -(ww5_yz + wd5_x)
    vd5_x = sin_th5*vd4_z + cos_th5*vd4_x
    vd5_y = cos_th5*vd4_z - sin_th5*vd4_x
    Fb5_1 = 8.0*vd5_x - 0.24*Fb5_1a
    Fb5_2 = 8.0*vd5_y - 0.24*Fb5_2a
    Fb5_3 = -(0.24*Fb5_3a + 8.0*vd4_y)
    Fb5_4 = 0.0272*ww5_yz - (0.24*vd4_y - 0.0672*wd5_x)
    Fb5_6 = -(0.0272*ww5_xy + 0.0672*wd4_y + 0.24*vd5_x)

    # Forward recursion: velocities, accelerations, wrenches, joint 6 (wrist_3) [1], [3], [6], [12].
    w6_z = qd6 + w5_y
    ww6_yz = -w5_z*w6_z
    wd6_x = ww6_yz - Fb5_3a
    ww6_xz = w5_x*w6_z
    wd6_y = -(Fb5_1a + ww6_xz)
    Fb6_6 = 0.006*wd5_y
    Fb6_1 = 3.0*vd5_x - 0.3*Fb5_1a
    Fb6_2 = 0.3*Fb5_3a + 3.0*vd4_y
    Fb6_3 = 3.0*vd5_y - 0.3*Fb5_2a
    Fb6_4 = -(0.034*ww6_yz + 0.3*vd4_y - 0.04*wd6_x)
    Fb6_5 = 0.034*ww6_xz + 0.04*wd6_y + 0.3*vd5_x

    # Forward recursion: velocities, accelerations, wrenches, joint 7 (crank) [1], [3], [6], [12].
    vd7_x = -(cos_th7*vd2_xa + 9.81*sin_th7)
    vd7_y = sin_th7*vd2_xa - 9.81*cos_th7
    Fb7_3 = -7.5*ww3_yz
    Fb7_4 = -0.2*ww3_xz
    Fb7_5 = -1.925*ww3_yz
    Fb7_6 = -(3.75*vd7_y + 0.8625*ww3_xy)

    # Forward recursion: velocities, accelerations, wrenches, joint 8 (rod) [1], [3], [6], [12].
    vd8_z = D8*Fb3_5a
    vd8_xa = -(vd7_x + D8*Fb3_2a)
    vd8_xb = vd7_y + D8*ww3_xy
    vd8_x = sin3_theta*vd8_xa - cos3_theta*vd8_xb
    vd8_y = -(cos3_theta*vd8_xa + sin3_theta*vd8_xb)
    Fb8_1 = 10.0*vd8_x - 4.0*vd3_xa
    Fb8_2 = 10.0*vd8_y + 4.0*ww2_xy
    Fb8_3 = 10.0*vd8_z + 8.0*ww2_xz
    Fb8_4 = 0.02*ww2_yz
    Fb8_6 = 4.0*vd8_y + 2.18*ww2_xy
    Fb8_5 = -(4.0*vd8_z + 4.38*ww2_xz)

    # Backward recursion: articulated inertias and wrenches, joint 7 (crank) [15].
    f7_3 = Fb7_3 + Fb8_3
    f7_6 = Fb7_6 + Fb8_6 + D8*(cos3_theta*Fb8_1 + sin3_theta*Fb8_2)
    f7_4 = Fb7_4 - (sin3_theta*Fb8_4 - cos3_theta*Fb8_5)
    f7_5 = Fb7_5 + D8*Fb8_3 - (cos3_theta*Fb8_4 + sin3_theta*Fb8_5)

    # Backward recursion: articulated inertias and wrenches, joint 5 (wrist_2) [15].
    f5_5 = 0.046*wd5_y
    f5_1 = Fb5_1 + Fb6_1
    f5_2 = Fb5_2 + Fb6_3
    f5_3 = Fb5_3 - Fb6_2
    f5_4 = Fb5_4 + Fb6_4
    f5_6 = Fb5_6 - Fb6_5

    # Backward recursion: articulated inertias and wrenches, joint 4 (wrist_1) [15].
    f4_1 = Fb4_1 - (sin_th5*f5_2 - cos_th5*f5_1)
    f4_2 = Fb4_2 - f5_3
    f4_3 = Fb4_3 + sin_th5*f5_1 + cos_th5*f5_2
    f4_4 = Fb4_4 + cos_th5*f5_4 - sin_th5*f5_5
    f4_5 = Fb4_5 - f5_6
    f4_6 = Fb4_6 + cos_th5*f5_5 + sin_th5*f5_4

    # Backward recursion: articulated inertias and wrenches, joint 3 (elbow) [15].
    f3_6a = f4_4 - RL4*f4_2
    f3_6b = f4_5 + RL4*f4_1
    f3_3a = sin_th4*f4_1 + cos_th4*f4_2
    f3_1 = Fb3_1 + cos_th4*f4_1 - sin_th4*f4_2
    f3_2 = Fb3_2 + f4_3
    f3_3 = Fb3_3 - f3_3a
    f3_6 = Fb3_6 - (sin_th4*f3_6a + cos_th4*f3_6b - D4*f4_3)
    f3_4 = cos_th4*f3_6a - sin_th4*f3_6b + Fb3_4
    f3_5 = f4_6 + D4*f3_3a + Fb3_5

    # Backward recursion: articulated inertias and wrenches, joint 2 (shoulder) [15].
    f2_3 = Fb2_3 + f3_3
    f2_6 = Fb2_6 + f3_6 + D3*(sin3_theta*f3_1 + cos3_theta*f3_2)
    f2_4 = Fb2_4 - (sin3_theta*f3_5 - cos3_theta*f3_4)
    f2_5 = Fb2_5 - (D3*f3_3 - (sin3_theta*f3_4 + cos3_theta*f3_5))

    # Backward recursion: articulated inertias and wrenches, joint 1 (waist) [15].
    f1_6 = D2*(f7_3 + f2_3) - (cos_th2*f2_5 + sin_th7*f7_4 + cos_th7*f7_5 + sin_th2*f2_4)

    # Composite inertias and inertia matrix, joint 7 (crank) [8], [13].
    J7_cyya = -4.0*sin3_theta
    MS7_c_y = -4.0*cos3_theta
    J7_cxya = -2.18*cos3_theta
    J7_cxxa = -cos3_theta*J7_cxya
    J7_cyyc = J7_cyya - J7_cyyb
    J7_cyyd = D8*(J7_cyya + J7_cyyc)
    J7_cxy = sin3_theta*J7_cxya + D8*MS7_c_y
    J7_cxx = J7_cxxa + 0.22
    J7_cyy = 1.0625 - (J7_cxxa - 2.2 + J7_cyyd)
    MS7_c_x = J7_cyyc - 3.75
    A2_7a = D8*J7_cyya
    A2_7b = A2_7a - 2.2
    A6_7a = 0.006*sin_th5
    A6_7 = sin_th4*A6_7a
    MS4_c_x = -0.54*sin_th5
    MS4_c_za = 0.54*cos_th5
    J4_cxza = 0.0612*sin_th5
    J4_cxxa = sin_th5*J4_cxza
    J4_cxz = cos_th5*J4_cxza
    J4_cxx = 2.7072 - J4_cxxa
    MS4_c_z = MS4_c_za - 6.0
    A5_7a = RL4*MS4_c_za + 0.1072
    A5_7 = cos_th4*A5_7a + D4*MS4_c_x
    J3_cxzb = MS4_c_z + J3_cxza
    J3_cxzc = RL4*(MS4_c_z + J3_cxzb)
    J3_cxzd = -(J4_cxx + J3_cxzc)
    J3_cxze = J3_cxzc + 2.7072
    A4_7a = J4_cxz - RL4*MS4_c_x
    J3_czza = -cos_th4*MS4_c_x
    MS3_c_z = -sin_th4*MS4_c_x
    J3_cxzf = sin_th4*(J3_cxzd + J3_cxze)
    J3_czzb = sin_th4*J3_cxzf
    A4_7 = -sin_th4*A4_7a
    J3_czzd = J3_czza - J3_czzc
    J3_czze = D4*(J3_czza + J3_czzd)
    J3_cxz = cos_th4*J3_cxzf - D4*MS3_c_z
    J3_czz = J3_cxze - J3_czzb - J3_czze + 5.4
    MS3_c_x = 4.0 - J3_czzd
    MS3_c_y = J3_cxzb + 10.0
    A2_7c = cos3_theta*MS3_c_x - sin3_theta*MS3_c_y
    A1_7a = sin3_theta*A4_7 - cos3_theta*J3_cxz
    J2_cyz = sin3_theta*J3_cxz + cos3_theta*A4_7
    A2_7d = J3_czz + D3*A2_7c
    A1_7b = -cos_th2*J2_cyz
    A1_7 = sin_th2*A1_7a + A1_7b
    A2_7e = J3_czz - A2_7d
    A2_7 = -(A2_7b + A2_7e + 2.2)
    A7_7 = A2_7a + J3_czz + A2_7b - (J7_cyyd - 3.8745)

    # Composite inertias and inertia matrix, joint 6 (wrist_3) [8], [13].
    A4_6 = 0.006*cos_th5
    A1_6a = cos_th4*A6_7a
    A1_6 = sin_th2*(cos3_theta*A1_6a + sin3_theta*A4_6) - cos_th2*(cos3_theta*A4_6 - sin3_theta*A1_6a)

    # Composite inertias and inertia matrix, joint 5 (wrist_2) [8], [13].
    A1_5a = sin_th4*A5_7a
    A1_5b = sin_th4*MS4_c_za
    A1_5c = D4*A1_5b
    A1_5 = (
        cos_th2*(cos3_theta*A1_5c - sin3_theta*A1_5a + D3*A1_5b) - sin_th2*(cos3_theta*A1_5a
        + sin3_theta*A1_5c) + D2*A1_5b
    )
    A2_5 = A5_7 + D3*(cos3_theta*MS4_c_x - sin3_theta*(cos_th4*MS4_c_za)) - A5_7

    # Composite inertias and inertia matrix, joint 4 (wrist_1) [8], [13].
    J4_czz = J4_cxxa + 0.146
    A1_4a = cos_th4*A4_7a
    A4_4 = J4_cxxa + 2.021
    A1_4b = J4_czz - D4*J3_czza
    A1_4 = (
        sin_th2*(sin3_theta*A1_4b - cos3_theta*A1_4a) + cos_th2*(D3*J3_czza
        - (sin3_theta*A1_4a + cos3_theta*A1_4b)) + D2*J3_czza
    )
    A2_4a = D3*MS3_c_z
    A2_4 = A4_7 + sin3_theta*A2_4a - A4_7

    # Composite inertias and inertia matrix, joint 3 (elbow) [8], [13].
    J3_cxx = 5.0 - (J3_cxzd - J3_czzb)
    J3_cxy = A1_4a - D4*J3_cxzb - 1.0
    J3_cyy = J4_czz - J3_czze + 1.2

    # Composite inertias and inertia matrix, joint 2 (shoulder) [8], [13].
    MS2_c_y = sin3_theta*MS3_c_x + cos3_theta*MS3_c_y
    J2_cxya = 2.0*cos3_theta*J3_cxy - sin3_theta*(J3_cyy - J3_cxx)
    J2_cxxa = -sin3_theta*J2_cxya
    J2_cyyb = A2_7c + J2_cyya
    J2_cyyc = D3*(A2_7c + J2_cyyb)
    J2_cxy = -(J3_cxy - cos3_theta*J2_cxya + D3*MS2_c_y)
    J2_cxx = J3_cxx + J2_cxxa + 0.75
    J2_cxz = -(A1_7a + A2_4a + 1.2)
    J2_cyy = J3_cyy - J2_cxxa + J2_cyyc + 13.75
    MS2_c_x = J2_cyyb + 24.0
    J1_cyz = A1_7b - sin_th2*J2_cxz
    A1_2 = J1_cyz - A1_7
    A2_2 = 2.2 - (A2_7d - (J3_czz + J2_cyyc + 21.1) - A2_7e)

    # Composite inertias and inertia matrix, joint 1 (waist) [8], [13].
    J1_czza = sin_th7*MS7_c_y - cos_th7*MS7_c_x
    J1_czzc = sin_th2*MS2_c_y - cos_th2*MS2_c_x
    J1_czz = (
        -(sin_th2*(sin_th2*(J2_cyy - J2_cxx) - 2.0*cos_th2*J2_cxy)
        - (J2_cyy + J7_cyy + sin_th7*(sin_th7*(J7_cxx - J7_cyy) + 2.0*cos_th7*J7_cxy) + 6.2)
        + D2*(J1_czza + J1_czza - J1_czzb + J1_czzc + J1_czzc - J1_czzd))
    )
    A1_1 = J1_czz + 30.0

    # Solution, from the tips to the base, joint 6 (wrist_3) [8].
    Gb6 = tau6 - Fb6_6

    # Solution, from the tips to the base, joint 5 (wrist_2) [8].
    Gb5 = tau5 - f5_6

    # Solution, from the tips to the base, joint 7 (crank) [8].
    H7a = 1.1918951132300357*A6_7
    H7b = 0.7649938800489596*A5_7
    H7 = A7_7 - A6_7*H7a - A5_7*H7b
    Hinv7 = 1.0/H7
    Gb7 = tau7 + Fb8_6 - (f7_6 + f3_6)

    # Solution, from the tips to the base, joint 4 (wrist_1) [8].
    H4a = 0.007151370679380214*cos_th5
    H4b = A4_6*H7a - A4_7
    H4c = H4b*Hinv7
    H4 = A4_4 - A4_6*H4a - H4b*H4c
    Hinv4 = 1.0/H4
    Gb4 = tau4 - f4_6

    # Solution, from the tips to the base, joint 2 (shoulder) [8].
    H2a = -0.7649938800489596*A2_5
    H2b = A2_5*H7b - A2_7
    H2c = H2b*Hinv7
    H2d = H2b*H4c - A2_4
    H2e = Hinv4*H2d
    H2 = -(H2b*H2c - (A2_2 + A2_5*H2a) + H2d*H2e)
    Hinv2 = 1.0/H2
    Gb2 = tau2 - (Fb8_6 + f2_6 - f3_6)

    # Solution, from the tips to the base, joint 1 (waist) [8].
    H1a = -1.1918951132300357*A1_6
    H1b = 0.7649938800489596*A1_5
    H1c = A1_7 - A1_6*H7a - A1_5*H7b
    H1d = H1c*Hinv7
    H1e = A1_4 - A1_6*H4a + H1c*H4c
    H1f = H1e*Hinv4
    H1g = -(A1_2 + A1_5*H2a + H1c*H2c + H1e*H2e)
    H1h = -H1g*Hinv2
    H1 = H1g*H1h - (H1e*H1f + H1c*H1d + A1_5*H1b - (A1_6*H1a + A1_1))
    Gb1 = tau1 - f1_6

    # Solution, from the base to the tips, joint 1 (waist) [8].
    qdd1a = H7a*Gb6 - Gb7 + H7b*Gb5
    qdd1b = H4a*Gb6 - Gb4 + H4c*qdd1a
    qdd1c = Gb2 + H2a*Gb5 - H2c*qdd1a - H2e*qdd1b
    qdd1 = -(H1h*qdd1c - (H1f*qdd1b + H1d*qdd1a - (H1b*Gb5 - (H1a*Gb6 + Gb1))))/H1

    # Solution, from the base to the tips, joint 2 (shoulder) [8].
    qdd2 = Hinv2*qdd1c - H1h*qdd1

    # Solution, from the base to the tips, joint 4 (wrist_1) [8].
    qdd4 = H2e*qdd2 - (Hinv4*qdd1b + H1f*qdd1)

    # Solution, from the base to the tips, joint 5 (wrist_2) [8].
    qdd7 = H4c*qdd4 - (Hinv7*qdd1a + H1d*qdd1 - H2c*qdd2)
    qdd5 = 0.7649938800489596*Gb5 - H1b*qdd1 + H2a*qdd2 - H7b*qdd7

    # Solution, from the base to the tips, joint 6 (wrist_3) [8].
    qdd6 = 1.1918951132300357*Gb6 + H1a*qdd1 - H4a*qdd4 - H7a*qdd7

    # Results.
    return (
        (qdd1, qdd2, qdd4, qdd5, qdd6, qdd7),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=6, qd=6, tau=6),
    parameters=5,
    results=((6,),),
)
