"""Weather files of the formats that have none at hand, made by their specifications; a sunny day over Boulder.

The light is a half sine between six and eighteen o'clock of local standard time, 800 W/m2 at noon.
"""

import datetime
import json
import math

LATITUDE, LONGITUDE, ALTITUDE, OFFSET_H = 40.0, -105.0, 1600.0, -7
FIRST = datetime.datetime(2015, 6, 20)


def light(hour):
    """Return (ghi, dni, dhi) at an hour of local time."""
    height = max(0.0, math.sin(math.pi * (hour - 6.0) / 12.0))
    ghi = 800.0 * height
    return ghi, 700.0 * (height > 0.0), 0.2 * ghi


def hours(days=3, step_min=60):
    """Yield local times of some days, and the light in the middle of each interval."""
    for minute in range(0, 1440 * days, step_min):
        at = FIRST + datetime.timedelta(minutes=minute)
        middle = at.hour + (at.minute + step_min / 2) / 60.0
        yield at, light(middle)


def utc(at):
    return at - datetime.timedelta(hours=OFFSET_H)


def epw():
    """EnergyPlus, Auxiliary Programs, "EnergyPlus Weather File (EPW) Data Dictionary": 8 lines, 35 fields."""
    head = [
        f"LOCATION,Boulder,CO,USA,TMY3,724699,{LATITUDE},{LONGITUDE},{OFFSET_H}.0,{ALTITUDE}",
        "DESIGN CONDITIONS,0",
        "TYPICAL/EXTREME PERIODS,0",
        "GROUND TEMPERATURES,0",
        "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0",
        "COMMENTS 1,made by the specification",
        "COMMENTS 2,",
        "DATA PERIODS,1,1,Data,Sunday,6/20,6/22",
    ]
    rows = []
    for at, (ghi, dni, dhi) in hours():
        fields = [at.year, at.month, at.day, at.hour + 1, 0, "?9", 20.5, 5.0, 40, 84000, 0, 1400, 350]
        fields += [round(ghi, 1), round(dni, 1), round(dhi, 1), 0, 0, 0, 0, 180, 2.5]
        fields += [3, 3, 9999, 99999, 9, 999999999, 10, 0.1, 0, 88, 0.2, 0, 0]
        rows.append(",".join(map(str, fields)))
    return "\n".join([*head, *rows]) + "\n"


def psm():
    """NSRDB, "Standard Time Series Data File Format" (NREL 2013): two lines of keys and values."""
    keys = "Source,Location ID,City,State,Country,Latitude,Longitude,Time Zone,Elevation,Local Time Zone"
    head = [keys, f"NSRDB,149190,-,-,-,{LATITUDE},{LONGITUDE},{OFFSET_H},{ALTITUDE:.0f},{OFFSET_H}"]
    names = "Year,Month,Day,Hour,Minute,GHI,DHI,DNI,Temperature,Wind Speed"
    rows = [
        f"{at.year},{at.month},{at.day},{at.hour},30,{ghi:.1f},{dhi:.1f},{dni:.1f},20.5,2.5"
        for at, (ghi, dni, dhi) in hours()
    ]
    return "\n".join([*head, names, *rows]) + "\n"


def pvgis_hourly():
    """PVGIS 5 "Hourly radiation data" (https://joint-research-centre.ec.europa.eu/pvgis): light on the tilted plane."""
    head = [
        f"Latitude (decimal degrees):\t{LATITUDE}",
        f"Longitude (decimal degrees):\t{LONGITUDE}",
        f"Elevation (m):\t{ALTITUDE}",
        "Radiation database:\tPVGIS-SARAH2",
        "",
        "",
        "Slope: 30 deg. ",
        "Azimuth: 0 deg. ",
        "time,Gb(i),Gd(i),Gr(i),H_sun,T2m,WS10m,Int",
    ]
    rows = [
        f"{utc(at):%Y%m%d:%H}30,{0.75 * ghi:.2f},{0.2 * ghi:.2f},{0.05 * ghi:.2f},10.0,20.5,2.5,0.0"
        for at, (ghi, _, _) in hours()
    ]
    return "\n".join([*head, *rows, "", "Gb(i): Beam irradiance on the inclined plane (W/m2)", ""]) + "\n"


def pvgis_tmy():
    """PVGIS 5 "TMY": a table of the months' years, then 8760 hours in universal time."""
    head = [
        f"Latitude (decimal degrees): {LATITUDE}",
        f"Longitude (decimal degrees): {LONGITUDE}",
        f"Elevation (m): {ALTITUDE}",
        "month,year",
        *(f"{month},{2006 + month}" for month in range(1, 13)),
        "time(UTC),T2m,RH,G(h),Gb(n),Gd(h),IR(h),WS10m,WD10m,SP",
    ]
    rows = []
    start = datetime.datetime(2015, 1, 1)
    for hour in range(8760):
        at = start + datetime.timedelta(hours=hour)
        ghi, dni, dhi = light((at.hour + OFFSET_H) % 24)
        rows.append(f"{2006 + at.month}{at:%m%d:%H}00,20.5,40.0,{ghi:.1f},{dni:.1f},{dhi:.1f},300.0,2.5,180,84000")
    return "\n".join([*head, *rows, "", "T2m: 2-m air temperature (degree Celsius)", ""]) + "\n"


def pvgis_tmy_json():
    """The same in PVGIS's JSON."""
    lines = pvgis_tmy().splitlines()
    start = next(place for place, line in enumerate(lines) if line.startswith("time(UTC)"))
    names = lines[start].split(",")
    rows = [line.split(",") for line in lines[start + 1 : start + 8761]]
    hourly = [
        {name: cell if name == "time(UTC)" else float(cell) for name, cell in zip(names, row, strict=True)}
        for row in rows
    ]
    location = {"latitude": LATITUDE, "longitude": LONGITUDE, "elevation": ALTITUDE}
    months = [{"month": month, "year": 2006 + month} for month in range(1, 13)]
    outputs = {"months_selected": months, "tmy_hourly": hourly}
    return json.dumps({"inputs": {"location": location}, "outputs": outputs, "meta": {"inputs": {}}})


def cams():
    """CAMS radiation service v4, "expert mode" CSV: # lines, periods in universal time, Wh/m2 in each."""
    head = [
        "# Coding: utf-8",
        "# Title: CAMS Radiation Service v4.0 all-sky irradiation",
        f"# Latitude (positive North, ISO 19115): {LATITUDE}",
        f"# Longitude (positive East, ISO 19115): {LONGITUDE}",
        f"# Altitude (m): {ALTITUDE}",
        "# Time reference: Universal time (UT)",
        "# Summarization (integration) period: 0 year 0 month 0 day 1 h 0 min 0 s",
        "# noValue: nan",
        "#",
        "# Observation period;TOA;Clear sky GHI;Clear sky BHI;Clear sky DHI;Clear sky BNI;GHI;BHI;DHI;BNI;Reliability",
    ]
    rows = []
    for at, (ghi, dni, dhi) in hours():
        end = utc(at) + datetime.timedelta(hours=1)
        period = f"{utc(at):%Y-%m-%dT%H:%M:%S.0}/{end:%Y-%m-%dT%H:%M:%S.0}"
        rows.append(f"{period};1000.0;0;0;0;0;{ghi:.4f};{ghi - dhi:.4f};{dhi:.4f};{dni:.4f};1.0")
    return "\n".join([*head, *rows]) + "\n"


def midc():
    """MIDC (https://midcdmz.nrel.gov), a site's daily export: DATE, zone, instruments with their units."""
    head = "DATE (MM/DD/YYYY),MST,Global Horizontal [W/m^2],Direct Normal [W/m^2],Diffuse Horizontal [W/m^2],"
    head += "Air Temperature [deg C],Avg Wind Speed @ 10m [m/s]"
    minute = datetime.timedelta(minutes=1)
    rows = [
        f"{at + minute:%m/%d/%Y,%H:%M},{ghi:.2f},{dni:.2f},{dhi:.2f},20.5,2.5" for at, (ghi, dni, dhi) in hours(1, 1)
    ]
    return "\n".join([head, *rows]) + "\n"


def surfrad():
    """NOAA SURFRAD README (https://gml.noaa.gov/aftp/data/radiation/surfrad/): 48 columns, each value with its flag."""
    rows = []
    for at, (ghi, dni, dhi) in hours(2, 5):
        time = utc(at)
        start = [
            time.year,
            time.timetuple().tm_yday,
            time.month,
            time.day,
            time.hour,
            time.minute,
            f"{time.hour:.3f}",
            45.0,
        ]
        values = {0: ghi, 2: dni, 3: dhi}
        pairs = " ".join(f"{values.get(place, 0.0):.1f} 0" for place in range(15))
        rows.append(" ".join(map(str, start)) + f" {pairs} 20.5 0 40.0 0 2.5 0 180.0 0 840.0 0")
    return "\n".join([" Boulder CO", f"   {LATITUDE}  {LONGITUDE} 1600 m version 1", *rows]) + "\n"


MADE = {
    "epw": (epw, "own.epw"),
    "psm4": (psm, "own.csv"),
    "pvgis_hourly": (pvgis_hourly, "Timeseries.csv"),
    "pvgis_tmy": (pvgis_tmy, "tmy.csv"),
    "cams": (cams, "cams.csv"),
    "midc": (midc, "20150620.csv"),
    "surfrad": (surfrad, "tbl15171.dat"),
}


def pvwatts():
    """NREL PVWatts v5, hourly results: pairs, a line of headings, 8760 rows without a year, a line of totals."""
    head = [
        '"PVWatts: Hourly PV Performance Data",""',
        '"Requested Location:","Boulder"',
        f'"Lat (deg N):","{LATITUDE}"',
        f'"Long (deg W):","{-LONGITUDE}"',
        f'"Elev (m):","{ALTITUDE}"',
        '"Array Tilt (deg):","30"',
        "",
        '"Month","Day","Hour","Beam Irradiance (W/m^2)","Diffuse Irradiance (W/m^2)","Ambient Temperature (C)",'
        '"Wind Speed (m/s)","Plane of Array Irradiance (W/m^2)","Cell Temperature (C)","DC Array Output (W)"',
    ]
    rows = [
        f'"{at.month}","{at.day}","{at.hour}","{dni:.0f}","{dhi:.1f}","20.5","2.5","{ghi:.1f}","30.0","1.0"'
        for at, (ghi, dni, dhi) in hours()
    ]
    return "\n".join([*head, *rows, '"Totals","","","","","","","","","99"']) + "\n"


def open_meteo():
    """Open-Meteo archive, CSV: two lines of the place, an empty one, headings with units; times of local time."""
    head = [
        "latitude,longitude,elevation,utc_offset_seconds,timezone,timezone_abbreviation",
        f"{LATITUDE},{LONGITUDE},{ALTITUDE},{3600 * OFFSET_H},America/Denver,GMT-7",
        "",
        "time,temperature_2m (°C),wind_speed_10m (km/h),shortwave_radiation (W/m²),diffuse_radiation (W/m²)",
    ]
    rows = [f"{at:%Y-%m-%dT%H:%M},20.5,9.0,{ghi:.1f},{dhi:.1f}" for at, (ghi, _, dhi) in hours()]
    return "\n".join([*head, *rows]) + "\n"


def solargis():
    """Solargis time series, CSV: # lines, semicolons, dates with points, a column of date and one of time."""
    head = [
        "#SOLARGIS TIME SERIES",
        f"#Latitude: {LATITUDE}",
        f"#Longitude: {LONGITUDE}",
        f"#Elevation: {ALTITUDE} m a.s.l.",
        "#Data:",
        "Date;Time;GHI;DNI;DIF;flagR;SE;SA;TEMP;AP;RH;WS;WD",
    ]
    rows = [
        f"{at:%d.%m.%Y};{at:%H}:30;{ghi:.1f};{dni:.1f};{dhi:.1f};1;10.0;100.0;20.5;840;40;2.5;180"
        for at, (ghi, dni, dhi) in hours()
    ]
    return "\n".join([*head, *rows]) + "\n"


def solcast():
    """Solcast, CSV: ends of periods in universal time, their length in ISO 8601."""
    rows = []
    for at, (ghi, dni, dhi) in hours():
        end = utc(at) + datetime.timedelta(hours=1)
        rows.append(f"20.5,{dhi:.1f},{dni:.1f},{ghi:.1f},2.5,{end:%Y-%m-%dT%H:%M:%S}+00:00,PT60M")
    return "\n".join(["air_temp,dhi,dni,ghi,wind_speed_10m,period_end,period", *rows]) + "\n"


def nasa_power():
    """NASA POWER, hourly CSV: a header between two marks, YEAR, MO, DY, HR."""
    head = [
        "-BEGIN HEADER-",
        "NASA/POWER CERES/MERRA2 Native Resolution Hourly Data ",
        f"Location: Latitude  {LATITUDE}   Longitude {LONGITUDE} ",
        "Elevation from MERRA-2: Average for 0.5 x 0.625 degree lat/lon region = 1600.0 meters",
        "-END HEADER-",
        "YEAR,MO,DY,HR,ALLSKY_SFC_SW_DWN,ALLSKY_SFC_SW_DNI,ALLSKY_SFC_SW_DIFF,T2M,WS10M",
    ]
    rows = [
        f"{at.year},{at.month},{at.day},{at.hour},{ghi:.1f},{dni:.1f},{dhi:.1f},20.5,2.5"
        for at, (ghi, dni, dhi) in hours()
    ]
    return "\n".join([*head, *rows]) + "\n"


def dwd():
    """DWD, 10-minute solar data: semicolons, MESS_DATUM without signs, J/cm2 in each interval."""
    rows = [
        f"5516;{utc(at):%Y%m%d%H%M};    3;{dhi * 0.06:.2f};{ghi * 0.06:.2f};  0.0; -999;eor"
        for at, (ghi, _, dhi) in hours(3, 10)
    ]
    return "\n".join(["STATIONS_ID;MESS_DATUM;   QN;DS_10;GS_10;SD_10;LS_10;eor", *rows]) + "\n"
