"""Files as other recorders write them."""

GERMAN = """\
Messung 12;Fahrer: K\xf6hler
Zeit;Achse vl;Aufbau;Bemerkung
s;g;m/s\xb2;
0,000;1,5;-0,25;los
0,010;2,5;-0,50;
0,020;3,5;-0,75;
0,030;4,5;-1,00;
"""

LVM = """\
LabVIEW Measurement\t
Writer_Version\t2
Reader_Version\t2
Separator\tTab
Decimal_Separator\t,
Multi_Headings\tYes
X_Columns\t{x_columns}
Time_Pref\tAbsolute
Operator\tsomebody
Date\t2024/02/19
Time\t09:51:39,1970510124996275989
***End_of_Header***\t
\t
"""
ONE = """\
Channels\t2\t\t
Samples\t3\t3\t
Date\t2024/02/19\t2024/02/19\t
Time\t09:51:{second:09.6f}\t09:51:{second:09.6f}\t
Y_Unit_Label\tg\tVolts\t
X_Dimension\tTime\tTime\t
X0\t0,0000000000000000E+0\t0,0000000000000000E+0\t
Delta_X\t7,812500E-3\t7,812500E-3\t
***End_of_Header***\t\t\t
X_Value\tA1\tAufbau\tComment
0,000000\t0,5\t1,25
0,007812\t-1,5\t1,50\tbump
0,015625\t2,5\t1,75
"""
G = 9.80665


def save(tmp_path, name, text, encoding="utf-8"):
    path = tmp_path / name
    path.write_bytes(text.encode(encoding))
    return path
